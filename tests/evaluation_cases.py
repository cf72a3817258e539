"""Evaluations made in code: scores of a simulated table, intervals of a set width."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scored_cases import CONDITIONS, SKILLS, scored_table

from affectsim_data.evaluation.confusion import (
    accuracies,
    confusion_codes,
    macro_f1_scores,
    recalls,
)
from affectsim_data.evaluation.results import (
    AcquisitionSummary,
    Benefit,
    Breakdown,
    ConditionScore,
    Estimate,
    Evaluation,
    GroupMean,
    ModelCard,
    PairedTest,
    ReferenceRow,
    RingCount,
    Settings,
    Subset,
)
from affectsim_data.evaluation.scored import OUTCOMES, RINGS_M, ScoredTable
from affectsim_data.motions import EMOTIONS

__all__ = ["HOSTILE_NAMES", "evaluation_case"]

HOSTILE_NAMES = (
    "<script>alert(1)</script>",
    "a|b **bold** [x](javascript:alert(1)) ![y](http://e.org/z.png)",
    r"\input{/etc/passwd} $x$ 50% #1 & ~ ^ {",
    '=HYPERLINK("http://e.org")',
    "../../etc/passwd",
    "\x1b[31mred\x1b[0m\x07 \x9b2J",
    "safe\u202egnp.exe\u2066 \u200bhidden",
    "two\nlines\r\n| --- |\n# heading",
    "[bold red]markup[/] [link=http://e.org]x[/link]",
    "模型-β-7B \N{ROBOT FACE}",
    "--",
    "x" * 200,
)
"""Names that are markup, formulas, paths, commands or control characters somewhere."""


def evaluation_case(
    *,
    models: Sequence[str] = ("alpha", "beta", "gamma"),
    groups: Mapping[str, str] | None = None,
    parameters: Mapping[str, str] | None = None,
    conditions: Sequence[str] = CONDITIONS,
    notes: Sequence[str] = (),
    without: Sequence[tuple[str, str]] = (),
    width: float = 0.04,
    seed: int = 0,
) -> Evaluation:
    """An evaluation whose scores are those of `scored_table`.

    Args:
        models: Recognizers.
        groups: Their groups, by model.
        parameters: Their sizes, by model.
        conditions: All they were run under.
        notes: What it notes.
        without: Models and conditions that were not run after all.
        width: Half of each interval.
        seed: Of the answers and of what is made up.
    """
    skills = {name: SKILLS.get(name, 0.0) for name in conditions}
    table = scored_table(models=models, conditions=conditions, skills=skills, seed=seed)
    has_active = table.acquisitions is not None
    subsets: tuple[Subset, ...] = ("all", "new_observation") if has_active else ("all",)
    cards = tuple(
        ModelCard(name, (groups or {}).get(name, ""), (parameters or {}).get(name, ""))
        for name in models
    )
    scores = tuple(
        _score(table, model, condition, subset, width)
        for subset in subsets
        for model in models
        for condition in conditions
        if (model, condition) not in without
    )
    benefits = tuple(_benefit(scores, name, subset, width) for subset in subsets for name in models)
    rng = np.random.default_rng(seed)
    return Evaluation(
        release=table.release,
        split=table.split,
        num_episodes=table.num_episodes,
        settings=Settings("performance", 60, 0.95, 2000, 2000, 0, "percentile"),
        models=cards,
        conditions=tuple(conditions),
        scores=scores,
        benefits=benefits,
        tests=tuple(
            _test(rng, name, condition)
            for name in models
            for condition in conditions
            if condition != "p_init" and "p_init" in conditions
        ),
        breakdowns=tuple(_breakdowns(table, width)),
        means=tuple(_means(cards, conditions, scores, benefits, width)),
        acquisition=_acquisition(table) if has_active else (),
        rings=tuple(RingCount(ring, 340, 12, 8) for ring in RINGS_M) if has_active else (),
        references=(
            *(ReferenceRow(f"constant:{emotion}", 1 / 15) for emotion in EMOTIONS),
            ReferenceRow("uniform", 0.1987),
            ReferenceRow("prior", 0.1991),
        ),
        chance=0.1987,
        notes=tuple(notes),
    )


def _around(value: float, width: float) -> Estimate:
    return Estimate(float(value), float(value) - width, float(value) + width)


def _confusion(table: ScoredTable, model: int, condition: int, chosen: np.ndarray) -> np.ndarray:
    codes = confusion_codes(table.truth[chosen], table.answers[model, condition, chosen])
    return np.bincount(codes, minlength=30).reshape(5, 6)


def _score(
    table: ScoredTable, model: str, condition: str, subset: Subset, width: float
) -> ConditionScore:
    places = table.models.index(model), table.conditions.index(condition)
    chosen = np.ones(table.num_episodes, bool)
    if subset == "new_observation":
        assert table.acquisitions is not None
        chosen = table.acquisitions.acquired
    confusion = _confusion(table, *places, chosen)
    answers = table.answers[places][chosen]
    valid = confusion.copy()
    valid[:, 5] = 0
    return ConditionScore(
        model=model,
        condition=condition,
        subset=subset,
        num_episodes=int(chosen.sum()),
        macro_f1=_around(macro_f1_scores(confusion[None])[0], width),
        accuracy=_around(accuracies(confusion[None])[0], width),
        macro_f1_valid=float(macro_f1_scores(valid[None])[0]),
        num_valid=int((answers >= 0).sum()),
        outcomes={name: int((answers == -1 - code).sum()) for code, name in enumerate(OUTCOMES)},
        recall={
            emotion: _around(share, 2 * width)
            for emotion, share in zip(EMOTIONS, recalls(confusion[None])[0], strict=True)
        },
        confusion=tuple(tuple(map(int, row)) for row in confusion),
        median_latency_ms=70.0,
    )


def _benefit(scores: Sequence[ConditionScore], model: str, subset: Subset, width: float) -> Benefit:
    found = {
        one.condition: one.macro_f1.value
        for one in scores
        if (one.model, one.subset) == (model, subset)
    }
    initial, reference, active, monitor = (
        found.get(name, math.nan) for name in ("p_init", "p_ref", "a_obs", "p_mon")
    )
    gap, gain = reference - initial, active - initial
    ogr = gain / gap if gap > 0 else math.nan
    recovery = 0.3 if "a_obs" in found else math.nan
    return Benefit(
        model=model,
        subset=subset,
        gain=_around(gain, width),
        gap=_around(gap, width),
        monitor_gap=_around(monitor - initial, width),
        ogr=_around(ogr, width) if gap > width else Estimate(ogr),
        recovery_rate=_around(recovery, width),
        num_initial_errors=211,
        e_spl={ring: _around(recovery / (1 + ring), width / 10) for ring in RINGS_M},
    )


def _test(rng: np.random.Generator, model: str, condition: str) -> PairedTest:
    mcnemar, permutation = (float(p) for p in rng.uniform(0.0, 0.5, 2) ** 4)
    return PairedTest(
        model=model,
        condition=condition,
        num_pairs=180,
        num_tied=180,
        only_initial=int(rng.integers(10, 40)),
        only_condition=int(rng.integers(30, 90)),
        mcnemar_p=mcnemar,
        permutation_p=permutation,
        mcnemar_holm_p=min(1.0, 3 * mcnemar),
        permutation_holm_p=min(1.0, 3 * permutation),
        detectable=0.043,
    )


def _breakdowns(table: ScoredTable, width: float) -> list[Breakdown]:
    found = []
    for factor in ("family", "challenge", "action", "emotion", "scene_id"):
        levels = table.factors[factor]
        for level in sorted(set(levels) - {""}):
            chosen = levels == level
            for model, name in enumerate(table.models):
                for place, condition in enumerate(table.conditions):
                    confusion = _confusion(table, model, place, chosen)[None]
                    accuracy = _around(accuracies(confusion)[0], width)
                    score = _around(macro_f1_scores(confusion)[0], width)
                    found.append(
                        Breakdown(
                            *(factor, str(level), name, condition, int(chosen.sum())),
                            num_clusters=len(np.unique(table.performances[chosen])),
                            macro_f1=accuracy if factor == "emotion" else score,
                            accuracy=accuracy,
                        )
                    )
    return found


def _means(
    cards: Sequence[ModelCard],
    conditions: Sequence[str],
    scores: Sequence[ConditionScore],
    benefits: Sequence[Benefit],
    width: float,
) -> list[GroupMean]:
    subsets = dict.fromkeys(one.subset for one in scores)
    found = []
    for group in dict.fromkeys(["", *(card.group for card in cards)]):
        names = {card.model for card in cards if not group or card.group == group}
        for subset in subsets:
            of_group = [one for one in benefits if one.model in names and one.subset == subset]
            chosen = [one for one in scores if one.model in names and one.subset == subset]
            gap = float(np.mean([one.gap.value for one in of_group]))
            gain = float(np.mean([one.gain.value for one in of_group]))
            ogrs = [one.ogr.value for one in of_group if not math.isnan(one.ogr.value)]
            found.append(
                GroupMean(
                    group=group,
                    subset=subset,
                    num_models=len(names),
                    macro_f1={name: _mean_score(chosen, name, width) for name in conditions},
                    recall={
                        name: {emotion: _mean_recall(chosen, name, emotion) for emotion in EMOTIONS}
                        for name in conditions
                    },
                    family_macro_f1={
                        family: {name: _mean_score(chosen, name, width) for name in conditions}
                        for family in ("action_grounded", "observation_controlled", "dyadic")
                    },
                    gain=_around(gain, width),
                    gap=_around(gap, width),
                    ogr_of_means=_around(gain / gap if gap > 0 else math.nan, width),
                    mean_ogr=_around(float(np.mean(ogrs)) if ogrs else math.nan, width),
                    num_ogr=len(ogrs),
                    recovery_rate=of_group[0].recovery_rate,
                    e_spl=of_group[0].e_spl,
                )
            )
    return found


def _mean_score(scores: Sequence[ConditionScore], condition: str, width: float) -> Estimate:
    values = [one.macro_f1.value for one in scores if one.condition == condition]
    return _around(float(np.mean(values)) if values else math.nan, width)


def _mean_recall(scores: Sequence[ConditionScore], condition: str, emotion: str) -> Estimate:
    values = [one.recall[emotion].value for one in scores if one.condition == condition]
    return _around(float(np.mean(values)) if values else math.nan, 0.05)


def _acquisition(table: ScoredTable) -> tuple[AcquisitionSummary, ...]:
    assert table.acquisitions is not None
    levels = [("", ""), *(("family", level) for level in sorted(set(table.factors["family"])))]
    return tuple(
        AcquisitionSummary(
            policy=table.acquisitions.policy,
            factor=factor,
            level=level,
            num_episodes=table.num_episodes if not factor else 120,
            stable_handoff=Estimate(0.4773, 0.45, 0.50),
            mean_path_m=Estimate(23.23, 22.0, 24.5),
            path_before_handoff=Estimate(0.974, 0.96, 0.98),
            budget_exhausted=Estimate(0.5227, 0.50, 0.55),
            clipped=Estimate(0.141, 0.12, 0.16),
            new_observations=int(table.acquisitions.acquired.sum()),
        )
        for factor, level in levels
    )
