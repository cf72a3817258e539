"""Policies by name: what `--policy` takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from affectsim_data.naming import named_object
from affectsim_data.simulation.policies.protocol import Policy

__all__ = ["open_policy", "policy_names"]

_ASKED_FOR = ("name", "reset", "act")


def open_policy(spec: str) -> Policy:
    """A policy from text such as `stay` or `random:60`.

    Args:
        spec: One of `policy_names`, or `module:PACKAGE.MODULE:NAME` for a policy of the caller's
            own: a class or function called without arguments, or an object as it is.

    Raises:
        ValueError: No such policy, or one that lacks what the protocol asks for.

    Examples:
        >>> open_policy("random:60").name
        'random:60'
    """
    if spec in _PLAIN:
        return _PLAIN[spec]()
    kind, colon, which = spec.partition(":")
    if kind == "random" and colon:
        return _random(which)
    if kind == "module" and colon:
        return _module(which)
    hint = f"; for a class of yours: module:{spec}" if "." in kind else ""
    raise ValueError(f"policy must be one of {', '.join(policy_names())}, got {spec!r}{hint}")


def policy_names() -> tuple[str, ...]:
    """What a policy can be called by, as text for people; without the capitals, as it is.

    Examples:
        >>> policy_names()[:3]
        ('stay', 'random', 'random:STEPS')
    """
    stay, random, *others = _PLAIN
    return (stay, random, "random:STEPS", *others, "module:PACKAGE.MODULE:NAME")


def _stay() -> Policy:
    from affectsim_data.simulation.policies.standing import StayPolicy

    return StayPolicy()


def _random(steps: str | None = None) -> Policy:
    from affectsim_data.simulation.policies.standing import RandomPolicy

    if steps is None:
        return RandomPolicy()
    if not (steps.isascii() and steps.isdecimal()):
        raise ValueError(f"random: takes a number of steps, a whole number from 0, got {steps!r}")
    return RandomPolicy(int(steps))


def _limited_search() -> Policy:
    from affectsim_data.simulation.policies.limited_search import LimitedSearch

    return LimitedSearch()


def _scan_search_follow() -> Policy:
    from affectsim_data.simulation.policies.scan_search_follow.policy import ScanSearchFollow

    return ScanSearchFollow()


def _straight_to_target() -> Policy:
    from affectsim_data.simulation.policies.guided import straight_to_target

    return straight_to_target()


def _reference() -> Policy:
    from affectsim_data.simulation.policies.guided import reference

    return reference()


def _module(path: str) -> Policy:
    """A class or function of the user's, called, or an object as it is."""
    policy = named_object(
        path,
        what="policy",
        attributes=_ASKED_FOR,
        protocol="affectsim_data.simulation.policies.Policy",
    )
    return cast(Policy, policy)


_PLAIN: dict[str, Callable[[], Policy]] = {
    "stay": _stay,
    "random": _random,
    "limited_search": _limited_search,
    "scan_search_follow": _scan_search_follow,
    "privileged:straight_to_target": _straight_to_target,
    "privileged:reference": _reference,
}
