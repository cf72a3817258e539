"""The paper's rows, and that its means, gains, counts and OGR follow from them."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from affectsim_data.evaluation.published import (
    PUBLISHED,
    PUBLISHED_EXECUTION,
    PUBLISHED_SUBSETS,
    published_means,
)

PAPER = Path(__file__).resolve().parents[2] / "shared" / "paper"
CONDITIONS = ("p_mon", "p_ref", "p_init", "a_obs")
PRINTED = {
    "Open-source mean (19)": [10.31, 15.56, 9.89, 11.70, 1.81, 3.10, 1.35, 0.73, 0.66],
    "Closed-source mean (5)": [24.44, 30.78, 22.61, 24.26, 1.64, 7.24, 3.03, 1.77, 1.23],
}
"""Rows of means in Tables 3 and 5."""


def test_means_are_those_printed() -> None:
    opened, closed, everything = published_means()
    for mean in (opened, closed):
        numbers = [mean.macro_f1[one] for one in CONDITIONS]
        numbers += [mean.gain, mean.recovery_rate, *mean.e_spl.values()]
        assert [round(number, 2) for number in numbers] == PRINTED[mean.name]
    assert (opened.num_models, closed.num_models, everything.num_models) == (19, 5, 24)
    assert [round(value, 2) for value in everything.e_spl.values()] == [1.70, 0.95, 0.78]


def test_ogr_is_that_of_means_before_rounding() -> None:
    opened, closed, _ = published_means()
    assert f"{opened.ogr_of_means:.3f}" == "0.320"
    assert f"{closed.ogr_of_means:.3f}" == "0.201"
    for mean, other in ((opened, "0.319"), (closed, "0.202")):
        p_ref, p_init, a_obs = PRINTED[mean.name][1:4]
        assert f"{(a_obs - p_init) / (p_ref - p_init):.3f}" == other
    assert (f"{opened.mean_ogr:.3f}", f"{closed.mean_ogr:.3f}") == ("0.344", "0.167")
    assert (opened.num_ogr, closed.num_ogr) == (18, 5)


def test_gains_and_counts_of_the_text() -> None:
    assert len(PUBLISHED) == 24
    for row in PUBLISHED:
        assert round(row.macro_f1["a_obs"] - row.macro_f1["p_init"], 2) == row.gain, row.model
    assert sum(row.gain > 0 for row in PUBLISHED) == 21
    best = [row for row in PUBLISHED if row.macro_f1["p_ref"] == max(row.macro_f1.values())]
    assert len(best) == 22
    assert sum(row.access == "open" for row in best) == 17


def test_table_4_repeats_the_means_of_table_3() -> None:
    opened, closed, _ = published_means()
    means = {"open": opened, "closed": closed}
    for row in PUBLISHED_SUBSETS:
        mean = means[row.access]
        # Means are rounded after subtraction, so a gain may be off by one in the last digit.
        assert row.gain == pytest.approx(row.a_obs - row.p_init, abs=0.0101)
        if row.subset == "all":
            shown = (mean.macro_f1["p_init"], mean.macro_f1["a_obs"], mean.gain)
            assert tuple(round(one, 2) for one in shown) == (row.p_init, row.a_obs, row.gain)
    assert PUBLISHED_EXECUTION.stable_handoff + PUBLISHED_EXECUTION.budget_exhausted == 100


@pytest.mark.skipif(not PAPER.is_dir(), reason="the paper's CSV files are not beside the checkout")
def test_rows_are_those_of_the_papers_files() -> None:
    with (PAPER / "table_main_results.csv").open(newline="") as file:
        main = [row for row in csv.DictReader(file) if " mean (" not in row["model"]]
    with (PAPER / "table_recovery_efficiency.csv").open(newline="") as file:
        recovery = [row for row in csv.DictReader(file) if " mean (" not in row["model"]]
    for ours, one, other in zip(PUBLISHED, main, recovery, strict=True):
        named = (ours.group, ours.model, ours.parameters or "--")
        assert named == (one["group"], one["model"], one["parameters"])
        assert named == (other["group"], other["model"], other["parameters"])
        assert [ours.macro_f1[name] for name in CONDITIONS] == [
            float(one[name]) for name in CONDITIONS
        ]
        assert ours.gain == float(one["gain_pp"])
        assert ours.recovery_rate == float(other["recovery_rate"])
        assert list(ours.e_spl.values()) == [float(other[f"e_spl_{r}m"]) for r in (1, 3, 5)]
