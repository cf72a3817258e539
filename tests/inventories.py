"""Performances without movement: all that planning reads of one is who does what, and how."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
from small_release import limb_avatar

from affectsim_data.avatars import Avatar
from affectsim_data.builders.compositions import read_compositions, read_split_rule
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.motions import EMOTIONS, Emotion, Motion


@functools.cache
def _body() -> Avatar:
    return limb_avatar("plain")


@functools.cache
def _still() -> tuple[np.ndarray, np.ndarray]:
    rotations = np.zeros((2, 22, 4))
    rotations[..., 0] = 1.0
    return np.tile([0.0, 0.9, 0.0], (2, 1)), rotations


@functools.cache
def still(
    performer_id: str,
    action: str,
    emotion: Emotion,
    *,
    take: int = 0,
    performance: str = "",
    group_id: str = "",
    partner_id: str = "",
) -> Performance:
    """Somebody who stands still in the name of an action; with `partner_id`, before another."""
    root, rotations = _still()

    def motion(who: str) -> Motion:
        name = f"{action}/{emotion}/{performer_id}{partner_id}/{performance}/{take}"
        return Motion(
            motion_id=f"{name}/{who}",
            performer_id=who,
            group_id=group_id or name,
            emotion=emotion,
            action=action,
            fps=30.0,
            root_translation=root,
            joint_rotations=rotations,
            performance=performance,
            take=take,
        )

    partner = (motion(partner_id), _body()) if partner_id else None
    return Performance(motion(performer_id), _body(), partner)


def asked_for(recipe: Recipe) -> list[Performance]:
    """A still performance for each that the `[[performances]]` of a recipe ask for."""
    tables = recipe.document["performances"]
    performances = []
    for table in tables:
        takes = table.get("takes", {})
        roles = [
            (who, action, "")
            for who in table.get("performers", ())
            for action in table.get("actions", ())
        ]
        roles += [(who, "interaction", partner) for who, partner in table.get("pairs", ())]
        performances += [
            still(who, action, emotion, take=take, partner_id=partner)
            for who, action, partner in roles
            for take in range(takes.get(action, 1))
            for emotion in EMOTIONS
        ]
    return performances


def planned(*entries: dict[str, Any], splits: dict[str, Any] | None = None) -> Recipe:
    """A recipe `test.toml` of such `[[compose]]` entries and `[splits]`; all else as in `mini`."""
    rule = None if splits is None else read_split_rule(splits, where="test.toml: [splits]")
    fields = vars(read_recipe("mini")) | {
        "compositions": read_compositions(entries, rule, where="test.toml"),
        "path": Path("test.toml"),
    }
    return Recipe(**fields)
