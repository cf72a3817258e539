"""Answers made by chance with known skill: to plan a study, and to check the statistics.

Each emotion gets a score in each clip, and the highest one is the answer: how much the recognizer
favours that word, how well it sees the right one under the condition, and noise. Part of the noise
is the performance's own, the same in all its episodes; part of it is common to all conditions.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import special

from affectsim_data.evaluation.scored import NUM_COLUMNS, RINGS_M, Acquisitions, ScoredTable
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = [
    "PAPER_SKILLS",
    "Plan",
    "Skill",
    "expected_confusions",
    "paper_plan",
    "simulated_answers",
    "simulated_table",
]


@dataclasses.dataclass(frozen=True)
class Plan:
    """Performances of a study, and how often each is replayed."""

    sizes: NDArray[np.int64]
    """Episodes of each performance, `(num_clusters,)`."""
    truth: NDArray[np.int8]
    """Index of the emotion of each performance, `(num_clusters,)`."""
    families: NDArray[np.str_]
    """Family of the episodes of each performance, `(num_clusters,)`."""
    fallback: NDArray[np.bool_]
    """Whether a_obs falls back to the clip of p_init, `(num_episodes,)`."""

    def __post_init__(self) -> None:
        count = (len(self.sizes),)
        for name, shape in {
            "truth": count,
            "families": count,
            "fallback": (int(self.sizes.sum()),),
        }.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must be {shape}, got {getattr(self, name).shape}")

    @classmethod
    def even(
        cls,
        families: Mapping[str, tuple[int, int]],
        *,
        fallback: float = 0.0,
        rng: np.random.Generator,
    ) -> Plan:
        """A plan with all performances of a family replayed equally often, emotions in turn.

        Args:
            families: Number of performances and of episodes, by family.
            fallback: Share of episodes whose a_obs is the clip of p_init.
            rng: Draws which ones.
        """
        sizes = [np.diff(np.arange(n + 1) * total // n) for n, total in families.values()]
        emotions = [np.arange(n) % len(EMOTIONS) for n, _ in families.values()]
        num_episodes = sum(total for _, total in families.values())
        ranks = rng.permutation(num_episodes)
        return cls(
            sizes=np.concatenate(sizes),
            truth=np.concatenate(emotions).astype(np.int8),
            families=np.repeat(list(families), [n for n, _ in families.values()]),
            fallback=ranks < round(fallback * num_episodes),
        )

    @property
    def clusters(self) -> NDArray[np.int64]:
        """Code of the performance of each episode, `(num_episodes,)`."""
        return np.repeat(np.arange(len(self.sizes)), self.sizes)

    @property
    def episode_truth(self) -> NDArray[np.int8]:
        """Index of the emotion of each episode, `(num_episodes,)`."""
        return self.truth[self.clusters]

    @property
    def episode_families(self) -> NDArray[np.str_]:
        """Family of each episode, `(num_episodes,)`."""
        return self.families[self.clusters]


def paper_plan() -> Plan:
    """The paper's test split: 3,941 episodes of 161 performances, 2,060 with fallback.

    It gives episodes by family and 84 + 7 performances. Of the action-grounded ones it says only
    that 2 actors gave them; 70 is what `builders/paper.toml` plans. Emotions are spread evenly.
    """
    return Plan.even(
        {"action_grounded": (70, 2899), "observation_controlled": (84, 832), "dyadic": (7, 210)},
        fallback=2060 / 3941,
        rng=np.random.default_rng(0),
    )


@dataclasses.dataclass(frozen=True)
class Skill:
    """How a recognizer answers."""

    signal: Mapping[str, float]
    """How much higher the right emotion scores, by condition; noise has standard deviation 1."""
    favour: tuple[float, ...] = (0.0,) * len(EMOTIONS)
    """How much higher each emotion scores whatever there is to be seen."""
    correlation: float = 0.2
    """Share of the variance of noise that is the performance's own."""
    shared: float = 0.5
    """Share of the variance of noise that is common to all conditions."""

    def __post_init__(self) -> None:
        if len(self.favour) != len(EMOTIONS):
            raise ValueError(f"favour must be of {len(EMOTIONS)} emotions, got {self.favour}")
        for name in ("correlation", "shared"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must be in [0, 1], got {getattr(self, name)}")


PAPER_SKILLS = {
    "open": Skill(
        signal={"p_mon": -0.011, "p_ref": 0.491, "p_init": -0.065, "a_obs": 0.34},
        favour=(0.0, 0.0, 0.3, 2.6, 0.0),
    ),
    "closed": Skill(
        signal={"p_mon": 0.316, "p_ref": 0.565, "p_init": 0.238, "a_obs": 0.382},
        favour=(0.0, 0.0, 0.6, 1.3, 0.5),
    ),
}
"""Recognizers that score the paper's mean Macro-F1 of open and closed models on `paper_plan`."""


def simulated_answers(
    plan: Plan, skill: Skill, rng: np.random.Generator, *, num_repeats: int = 1
) -> NDArray[np.int8]:
    """Answers of as many studies, `(num_repeats, num_conditions, num_episodes)`.

    They are indices of emotions, conditions in the order of `skill.signal`. Performances are drawn
    anew in each study; the plan and where there is fallback stay.
    """
    clusters, conditions = plan.clusters, tuple(skill.signal)
    scores = np.zeros((num_repeats, len(conditions), len(clusters), len(EMOTIONS)), np.float32)
    for own, of_clusters in ((skill.correlation, True), (1 - skill.correlation, False)):
        for share, copies in ((skill.shared, 1), (1 - skill.shared, len(conditions))):
            rows = len(plan.sizes) if of_clusters else len(clusters)
            noise = rng.standard_normal((num_repeats, copies, rows, len(EMOTIONS)), np.float32)
            noise *= np.float32(np.sqrt(own * share))
            scores += noise[:, :, clusters] if of_clusters else noise
    scores += _mean_scores(skill).astype(np.float32)[:, plan.episode_truth]
    answers: NDArray[np.int8] = scores.argmax(axis=-1).astype(np.int8)
    if {"a_obs", "p_init"} <= set(conditions):
        active, initial = conditions.index("a_obs"), conditions.index("p_init")
        answers[:, active, plan.fallback] = answers[:, initial, plan.fallback]
    return answers


def expected_confusions(plan: Plan, skill: Skill) -> FloatArray:
    """Confusions with a chance for every answer, `(num_conditions, 5, 6)`: the truth of scores.

    Conditions are in the order of `skill.signal`.
    """
    chances = _answer_chances(_mean_scores(skill))
    totals = np.bincount(plan.episode_truth, minlength=len(EMOTIONS))
    confusions = np.zeros((len(chances), len(EMOTIONS), NUM_COLUMNS))
    confusions[..., :-1] = chances * totals[:, None]
    conditions = tuple(skill.signal)
    if {"a_obs", "p_init"} <= set(conditions):
        active, initial = conditions.index("a_obs"), conditions.index("p_init")
        tied = np.bincount(plan.episode_truth[plan.fallback], minlength=len(EMOTIONS))
        confusions[active, :, :-1] += tied[:, None] * (chances[initial] - chances[active])
    return confusions


def simulated_table(
    plan: Plan, skills: Mapping[str, Skill], rng: np.random.Generator
) -> ScoredTable:
    """A table of one simulated study, to be evaluated as if it were real.

    What recognizers do not decide (ways of the robot, scenes, challenges) has no meaning in it.

    Args:
        plan: Performances and episodes.
        skills: How each model answers; all under the same conditions.
        rng: Draws everything.
    """
    conditions = tuple(next(iter(skills.values())).signal)
    if any(tuple(skill.signal) != conditions for skill in skills.values()):
        raise ValueError(f"all skills must have signals of {conditions}, in this order")
    count, clusters = len(plan.clusters), plan.clusters
    answers = np.stack([simulated_answers(plan, skill, rng)[0] for skill in skills.values()])
    same = np.zeros((len(conditions), count), bool)
    for place, condition in enumerate(conditions):
        same[place] = condition == "p_init" or (condition == "a_obs") * plan.fallback
    return ScoredTable(
        release="simulated",
        split="test",
        episode_ids=np.array([f"simulated/test-{place:05d}" for place in range(count)]),
        truth=plan.episode_truth,
        factors=_factors(plan, rng),
        performances=clusters,
        performers=clusters % 12,
        models=tuple(skills),
        conditions=conditions,
        answers=answers,
        was_run=np.ones(answers.shape[:2], bool),
        latency_ms=np.full(answers.shape, np.nan, np.float32),
        same_frames=same,
        d_star_m=rng.uniform(0.0, 8.0, (len(RINGS_M), count)),
        ring_empty=np.zeros((len(RINGS_M), count), bool),
        acquisitions=_acquisitions(plan, rng) if "a_obs" in conditions else None,
    )


def _factors(plan: Plan, rng: np.random.Generator) -> dict[str, NDArray[np.str_]]:
    count, clusters, families = len(plan.clusters), plan.clusters, plan.episode_families
    challenges = np.array(["far_visible", "rear_view", "partial_occlusion", "obstacle_detour"])
    with_challenge = families == "observation_controlled"
    ids = clusters.astype(str)
    return {
        "family": families,
        "challenge": np.where(with_challenge, challenges[rng.integers(0, 4, count)], ""),
        "action": np.char.add("action_", (clusters % 6).astype(str)),
        "emotion": np.array(EMOTIONS)[plan.episode_truth],
        "scene_id": np.char.add("scene_", rng.integers(0, 57, count).astype(str)),
        "performer_id": np.char.add("performer_", (clusters % 12).astype(str)),
        "motion_id": np.char.add("motion_", ids),
        "group_id": np.char.add("group_", ids),
        "placement_id": np.char.add("placement_", np.arange(count).astype(str)),
    }


def _acquisitions(plan: Plan, rng: np.random.Generator) -> Acquisitions:
    acquired, count = ~plan.fallback, len(plan.fallback)
    path = rng.uniform(0.0, 30.0, count)
    translations = np.ceil(path / 0.25).astype(np.int64)
    return Acquisitions(
        policy="simulated",
        path_length_m=path,
        path_before_handoff_m=np.where(acquired, path * rng.uniform(0.5, 1.0, count), path),
        num_steps=translations,
        planner_calls=rng.integers(0, 80, count),
        num_translations=translations,
        num_clipped=rng.binomial(translations, 0.05),
        handed_off=acquired,
        acquired=acquired,
        budget_exhausted=plan.fallback,
    )


def _mean_scores(skill: Skill) -> FloatArray:
    """Mean score of each emotion by condition and truth, `(num_conditions, 5, 5)`."""
    signals = np.array(list(skill.signal.values()), np.float64)
    means: FloatArray = signals[:, None, None] * np.eye(len(EMOTIONS)) + np.array(skill.favour)
    return means


def _answer_chances(means: FloatArray) -> FloatArray:
    """Chance that each score `(..., n)` is the highest, all with noise of deviation 1."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(80)
    levels = means[..., None, :, None] + nodes
    below = special.ndtr(levels - means[..., :, None, None])
    places = np.arange(means.shape[-1])
    below[..., places, places, :] = 1.0
    chances: FloatArray = below.prod(axis=-3) @ (weights / weights.sum())
    return chances
