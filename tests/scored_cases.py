"""Tables of answers made in code: performances that are easy or hard, models of known skill."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.evaluation.scored import OUTCOMES, RINGS_M, Acquisitions, ScoredTable
from affectsim_data.motions import EMOTIONS

CONDITIONS = ("p_mon", "p_ref", "p_init", "a_obs")
SKILLS = {"p_mon": -0.9, "p_ref": 0.6, "p_init": -0.8, "a_obs": 0.1}
"""Log odds of a right answer, of an average performance."""


def scored_table(
    *,
    models: Sequence[str] = ("alpha", "beta"),
    conditions: Sequence[str] = CONDITIONS,
    skills: Mapping[str, float] = SKILLS,
    num_performances: int = 60,
    num_per_performance: int = 6,
    spread: float = 1.0,
    unparsed: float = 0.05,
    seed: int = 0,
) -> ScoredTable:
    """A table with clusters: `spread` is that of performances, in log odds.

    Half of the episodes of a_obs, if it is there, fall back to the answers of p_init.
    """
    rng = np.random.default_rng(seed)
    count = num_performances * num_per_performance
    performances = np.repeat(np.arange(num_performances), num_per_performance)
    truth = (performances % len(EMOTIONS)).astype(np.int8)
    performers = performances % 7
    family = np.array(["action_grounded", "observation_controlled", "dyadic"])[performances % 3]
    challenges = np.array(["far_visible", "rear_view", "partial_occlusion", "obstacle_detour"])
    challenge = challenges[np.arange(count) % 4]
    challenge[family != "observation_controlled"] = ""
    factors = {
        "family": family,
        "challenge": challenge,
        "action": np.array(["simple_walk", "knock_door", "sit_down"])[performances % 3],
        "emotion": np.array(EMOTIONS)[truth],
        "scene_id": np.array([f"home_{index % 5}" for index in range(count)]),
        "performer_id": np.array([f"performer_{index}" for index in performers]),
        "motion_id": np.array([f"motion_{index:03d}" for index in performances]),
        "group_id": np.array([f"group_{index:03d}" for index in performances]),
        "placement_id": np.array([f"placement_{index}" for index in range(count)]),
    }
    ease = rng.normal(0.0, spread, num_performances)[performances]
    answers = np.empty((len(models), len(conditions), count), np.int8)
    for model in range(len(models)):
        for place, condition in enumerate(conditions):
            right = rng.random(count) < 1 / (1 + np.exp(-ease - skills[condition] - 0.3 * model))
            wrong = (truth + rng.integers(1, len(EMOTIONS), count)) % len(EMOTIONS)
            answers[model, place] = np.where(right, truth, wrong)
            lost = rng.random(count) < unparsed
            answers[model, place, lost] = -rng.integers(1, len(OUTCOMES), lost.sum())
    same = np.zeros((len(conditions), count), bool)
    acquisitions = None
    if "p_init" in conditions:
        initial = list(conditions).index("p_init")
        same[initial] = True
        if "a_obs" in conditions:
            active = list(conditions).index("a_obs")
            fallback = rng.random(count) < 0.5
            same[active] = fallback
            answers[:, active, fallback] = answers[:, initial, fallback]
            acquisitions = _acquisitions(~fallback, rng)
    d_star_m = rng.uniform(0.0, 8.0, (len(RINGS_M), count))
    gone = rng.random(d_star_m.shape) < 0.05
    d_star_m[gone] = np.nan
    return ScoredTable(
        release="simulated",
        split="test",
        episode_ids=np.array([f"simulated/test-{index:05d}" for index in range(count)]),
        truth=truth,
        factors=factors,
        performances=performances,
        performers=performers,
        models=tuple(models),
        conditions=tuple(conditions),
        answers=answers,
        was_run=np.ones(answers.shape[:2], bool),
        latency_ms=rng.uniform(50, 90, answers.shape).astype(np.float32),
        same_frames=same,
        d_star_m=d_star_m,
        ring_empty=gone & (rng.random(gone.shape) < 0.5),
        acquisitions=acquisitions,
    )


def _acquisitions(acquired: np.ndarray, rng: np.random.Generator) -> Acquisitions:
    count = len(acquired)
    path = rng.uniform(0.0, 30.0, count)
    translations = (path / 0.25).astype(np.int64) + 1
    return Acquisitions(
        policy="simulated_policy",
        path_length_m=path,
        path_before_handoff_m=np.where(acquired, path * rng.uniform(0.5, 1.0, count), path),
        num_steps=np.where(acquired, translations, 480),
        planner_calls=rng.integers(0, 80, count),
        num_translations=translations,
        num_clipped=rng.integers(0, 4, count).clip(max=translations),
        handed_off=acquired,
        acquired=acquired,
        budget_exhausted=~acquired,
    )


def only(table: ScoredTable, *conditions: str) -> ScoredTable:
    """The table with these conditions only."""
    places = [table.conditions.index(name) for name in conditions]
    return dataclasses.replace(
        table,
        conditions=conditions,
        answers=table.answers[:, places],
        was_run=table.was_run[:, places],
        latency_ms=table.latency_ms[:, places],
        same_frames=table.same_frames[places],
        acquisitions=table.acquisitions if "a_obs" in conditions else None,
    )
