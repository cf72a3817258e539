"""Recognizers by name: what `--recognizer` takes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from affectsim_data.motions import EMOTIONS
from affectsim_data.naming import named_object
from affectsim_data.recognizers.prompts import option_order
from affectsim_data.recognizers.protocol import Recognizer

__all__ = ["open_recognizer", "recognizer_kinds"]


def open_recognizer(spec: str, **options: Any) -> Recognizer:
    """A recognizer from text such as `openai:gpt-4o` and its options.

    Args:
        spec: `KIND:WHICH`; see `recognizer_kinds`.
        options: Of that kind; `None` for those left at their default.

    Raises:
        ValueError: No such kind, an option that does not go with it, or a recognizer that lacks
            what the protocol asks for.
        MissingExtraError: What it runs on is not installed.

    Examples:
        >>> open_recognizer("constant:happy").name
        'constant:happy'
    """
    kind, colon, which = spec.partition(":")
    if kind not in _KINDS or not colon or not which:
        hint = f"; for a class of yours: module:{spec}" if "." in kind else ""
        raise ValueError(
            f"recognizer must be one of {', '.join(recognizer_kinds())}, got {spec!r}{hint}"
        )
    opener, _ = _KINDS[kind]
    given = {name: value for name, value in options.items() if value is not None}
    taken = _options_of(opener)
    if taken is not None and (wrong := [name for name in given if name not in taken]):
        known = f"it takes {', '.join(taken)}" if taken else "it takes no options"
        raise ValueError(f"{kind}: does not go with {', '.join(wrong)}; {known}")
    return opener(which, **given)


def recognizer_kinds() -> tuple[str, ...]:
    """What a recognizer can be called by, as text for people.

    Examples:
        >>> recognizer_kinds()[0]
        'network:FILE.safetensors'
    """
    return tuple(f"{kind}:{which}" for kind, (_, which) in _KINDS.items())


def _options_of(opener: Callable[..., Recognizer]) -> list[str] | None:
    """Names of the options; `None` where whoever is opened knows them."""
    parameters = list(inspect.signature(opener).parameters.values())[1:]
    if any(one.kind is one.VAR_KEYWORD for one in parameters):
        return None
    return [one.name for one in parameters]


def _network(path: str, *, device: str = "cpu") -> Recognizer:
    from affectsim_data.recognizers.network import NetworkRecognizer

    return NetworkRecognizer.from_file(Path(path), device=device)


def _openai(
    model: str,
    *,
    api_key_env: str = "OPENAI_API_KEY",
    max_new_tokens: int = 256,
    option_seed: int | None = None,
    **others: Any,
) -> Recognizer:
    from affectsim_data.recognizers.endpoint import EndpointRecognizer

    known = inspect.signature(EndpointRecognizer).parameters
    if wrong := [name for name in others if name not in known]:
        raise ValueError(
            f"openai: does not go with {', '.join(wrong)}; it takes {', '.join(known)}"
        )
    set_: dict[str, Any] = {
        name: None if value == "unset" else value for name, value in others.items()
    }
    return EndpointRecognizer(
        model,
        api_key_env=api_key_env,
        max_tokens=max_new_tokens,
        options=option_order(option_seed),
        **set_,
    )


def _transformers(
    model: str,
    *,
    device: str = "cpu",
    revision: str | None = None,
    dtype: str = "auto",
    max_new_tokens: int = 64,
    option_seed: int | None = None,
) -> Recognizer:
    from affectsim_data.recognizers.local_model import TransformersRecognizer

    return TransformersRecognizer(
        model,
        device=device,
        revision=revision,
        dtype=dtype,
        options=option_order(option_seed),
        max_new_tokens=max_new_tokens,
    )


def _constant(emotion: str) -> Recognizer:
    from affectsim_data.recognizers.chance import ConstantRecognizer

    for one in EMOTIONS:
        if one == emotion:
            return ConstantRecognizer(one)
    raise ValueError(f"constant: must be one of {', '.join(EMOTIONS)}, got {emotion!r}")


def _uniform(seed: str) -> Recognizer:
    from affectsim_data.recognizers.chance import UniformRecognizer

    if not seed.isdecimal():
        raise ValueError(f"uniform: takes a seed, a whole number from 0 up, got {seed!r}")
    return UniformRecognizer(int(seed))


def _module(path: str, **options: Any) -> Recognizer:
    """A class of the user's, called with the options, or an object as it is."""
    recognizer = named_object(
        path,
        what="recognizer",
        attributes=("name", "batch_size", "recognize"),
        protocol="affectsim_data.recognizers.Recognizer",
        **options,
    )
    return cast(Recognizer, recognizer)


_KINDS: dict[str, tuple[Callable[..., Recognizer], str]] = {
    "network": (_network, "FILE.safetensors"),
    "openai": (_openai, "MODEL"),
    "transformers": (_transformers, "MODEL_OR_FOLDER"),
    "constant": (_constant, "EMOTION"),
    "uniform": (_uniform, "SEED"),
    "module": (_module, "PACKAGE.MODULE:NAME"),
}
