"""The tables of the paper's experiments, in its layout: columns, groups, decimals, what is bold."""

from __future__ import annotations

from collections.abc import Sequence

from affectsim_data.evaluation.results import (
    Benefit,
    Estimate,
    Evaluation,
    GroupMean,
    ModelCard,
    Subset,
)
from affectsim_data.evaluation.scored import RINGS_M
from affectsim_data.reports.tables.columns import (
    change_column,
    execution_cells,
    execution_columns,
    score_columns,
)
from affectsim_data.reports.tables.gathering import (
    above_chance,
    find_mean,
    gathered,
    model_columns,
    needs,
    reference_rows,
)
from affectsim_data.reports.tables.model import Cell, Column, Row, Table, number

__all__ = ["paper_tables"]

_TOPIC = "Tables of the paper"
_SUBSETS: dict[Subset, str] = {
    "all": "Complete test set",
    "new_observation": "New-observation subset",
}


def paper_tables(evaluation: Evaluation) -> list[Table]:
    """Tables 3 to 6 of the paper, as far as there are numbers for them."""
    tables = [_main_results(evaluation)]
    if "a_obs" in evaluation.conditions and "p_init" in evaluation.conditions:
        if any(mean.subset == "new_observation" for mean in evaluation.means):
            tables.append(_new_observations(evaluation))
        tables.append(_recovery_efficiency(evaluation))
    if evaluation.acquisition:
        tables.append(_execution(evaluation))
    return tables


def _main_results(evaluation: Evaluation) -> Table:
    """Table 3: Macro-F1 by condition, and the gain; where nothing moved, the gap."""
    has_active = "a_obs" in evaluation.conditions
    change = change_column("gain" if has_active else "gap", digits=2, interval="kept")

    def entry(card: ModelCard) -> list[Cell]:
        found = [evaluation.score(card.model, name) for name in evaluation.conditions]
        benefit = evaluation.benefit(card.model)
        scores = [one.macro_f1 if one else None for one in found]
        if benefit is None:
            return _scores(evaluation, scores, None)
        return _scores(evaluation, scores, benefit.gain if has_active else benefit.gap)

    def mean(group: GroupMean) -> list[Cell]:
        scores = [group.macro_f1.get(name) for name in evaluation.conditions]
        return _scores(evaluation, scores, group.gain if has_active else group.gap)

    columns = (*model_columns(evaluation), *score_columns(evaluation.conditions), change)
    return Table(
        name="main_results",
        title="Macro-F1 (%) by observation condition",
        caption=(
            f"Macro-F1 (%) over the {evaluation.num_episodes:,} episodes, as in Table 3 of the "
            "paper. Every condition of a row is answered by the same recognizer about the same "
            "episodes; what could not be parsed counts as wrong. The last rows answer without "
            "looking." + (" Bold: A-Obs where it is above P-Init." if has_active else "")
        ),
        columns=columns,
        rows=(*gathered(evaluation, entry, mean), *_reference_rows(evaluation, len(columns))),
        num_keys=len(model_columns(evaluation)),
        topic=_TOPIC,
    )


def _reference_rows(evaluation: Evaluation, num_columns: int) -> list[Row]:
    num_scores = len(evaluation.conditions)
    rest = num_columns - num_scores - len(model_columns(evaluation))
    return reference_rows(evaluation, num_scores, rest)


def _scores(
    evaluation: Evaluation, scores: Sequence[Estimate | None], change: Estimate | None
) -> list[Cell]:
    """Cells by condition, A-Obs bold where it is better than P-Init; then the change."""
    by_condition = dict(zip(evaluation.conditions, scores, strict=True))
    initial, active = by_condition.get("p_init"), by_condition.get("a_obs")
    improved = initial is not None and active is not None and active.value > initial.value
    cells = [
        above_chance(score, evaluation.chance, best=improved and name == "a_obs")
        for name, score in by_condition.items()
    ]
    pair = ("p_init", "a_obs" if "a_obs" in evaluation.conditions else "p_ref")
    missing = any(by_condition.get(name) is None for name in pair)
    return [*cells, number(None if missing else change)]


def _new_observations(evaluation: Evaluation) -> Table:
    """Table 4: the complete test set beside the episodes with a new clip, by group."""
    groups = [name for name in dict.fromkeys(card.group for card in evaluation.models) if name]
    groups = groups if len(groups) > 1 else []
    rows = [
        Row(_subset_cells(evaluation, mean))
        for group in [*groups, ""]
        for subset in _SUBSETS
        if (mean := find_mean(evaluation, group, subset)) is not None
    ]
    counts = {one.subset: one.num_episodes for one in evaluation.scores}
    return Table(
        name="new_observations",
        title="Complete test set and new-observation subset",
        caption=(
            f"Mean Macro-F1 (%) over the {counts.get('all', 0):,} episodes and over the "
            f"{counts.get('new_observation', 0):,} in which the policy collected a new clip after "
            "its handoff, as in Table 4 of the paper. In all others A-Obs is the paired P-Init "
            "clip. Which episodes these are depends on the policy. Bold: above P-Init."
        ),
        columns=(
            Column("group", "Model group"),
            Column("subset", "Episodes of"),
            Column("episodes", "Episodes", "count"),
            *score_columns(("p_init", "a_obs")),
            change_column("gain", digits=2, interval="kept"),
        ),
        rows=(*rows, _subset_chance(evaluation)),
        num_keys=2,
        topic=_TOPIC,
    )


def _subset_chance(evaluation: Evaluation) -> Row:
    chance = Cell(evaluation.chance)
    return Row((Cell("Chance (uniform)"), Cell(), Cell(), chance, chance, Cell()), "reference")


def _subset_cells(evaluation: Evaluation, mean: GroupMean) -> tuple[Cell, ...]:
    counts = {one.subset: one.num_episodes for one in evaluation.scores}
    initial, active = (mean.macro_f1.get(name) for name in ("p_init", "a_obs"))
    improved = mean.gain.value > 0
    return (
        Cell(f"{mean.group or 'All models'} ({mean.num_models})"),
        Cell(_SUBSETS[mean.subset]),
        Cell(counts.get(mean.subset, 0)),
        above_chance(initial, evaluation.chance),
        above_chance(active, evaluation.chance, best=improved),
        number(mean.gain, best=improved),
    )


def _recovery_efficiency(evaluation: Evaluation) -> Table:
    """Table 5: how many errors were mended, and at what length of way."""

    def cells(one: Benefit | GroupMean | None) -> list[Cell]:
        # Undefined E-SPL has two reasons: no trajectories at all, or no episode with a ring.
        rings = [None if one is None else one.e_spl.get(ring) for ring in RINGS_M]
        recovery = None if one is None else one.recovery_rate
        return [
            needs(recovery, "p_init", "a_obs", of=evaluation),
            *[number(ring, why="c" if evaluation.acquisition else "f") for ring in rings],
        ]

    return Table(
        name="recovery_efficiency",
        title="Recovery rate and E-SPL (%)",
        caption=(
            "Recovery rate (share of the wrong answers under P-Init that are right under A-Obs) "
            "and E-SPL (right answers under A-Obs, weighted by the shortest way to the ring over "
            f"the way taken), %, as in Table 5 of the paper. {_ring_counts(evaluation)}"
        ),
        columns=(
            *model_columns(evaluation),
            Column("recovery_rate", "Recovery rate", "percent", "", 2, "kept"),
            *[
                Column(f"e_spl_{ring}m", f"E-SPL @{ring} m", "percent", "", 2, "kept")
                for ring in RINGS_M
            ],
        ),
        rows=tuple(gathered(evaluation, lambda card: cells(evaluation.benefit(card.model)), cells)),
        num_keys=len(model_columns(evaluation)),
        topic=_TOPIC,
    )


def _ring_counts(evaluation: Evaluation) -> str:
    if not evaluation.rings:
        return ""
    counts = ", ".join(f"{ring.num_valid:,} at {ring.distance_m} m" for ring in evaluation.rings)
    return f"Episodes whose ring is empty or out of reach are left out, which leaves {counts}."


def _execution(evaluation: Evaluation) -> Table:
    """Table 6: how the policy behaved."""
    whole = [one for one in evaluation.acquisition if not one.factor]
    return Table(
        name="execution",
        title="What the policy did",
        caption=(
            "As in Table 6 of the paper: the mean path is per episode, handoff and exhausted "
            "budget are shares of episodes, the way before the handoff is a share of all "
            "locomotion, clipped moves are a share of attempted translations."
        ),
        columns=(
            Column("policy", "Policy"),
            Column("episodes", "Episodes", "count"),
            *execution_columns("kept"),
        ),
        rows=tuple(
            Row((Cell(one.policy), Cell(one.num_episodes), *execution_cells(one))) for one in whole
        ),
        topic=_TOPIC,
    )
