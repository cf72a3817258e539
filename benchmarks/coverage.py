"""How often intervals hold the truth and tests err, on the paper's clusters; figure and tables.

python -m benchmarks.coverage [--repeats 2000] [--json FILE]

writes docs/images/coverage.png, and the tables of docs/statistics.md between their markers. Takes
some ten minutes on one core.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from affectsim_data.evaluation.bootstrap import effective_clusters
from affectsim_data.evaluation.coverage import STUDY_METRICS, measure_coverage, measure_errors
from affectsim_data.evaluation.power import mean_standard_error, minimum_detectable_effect
from affectsim_data.evaluation.simulating import (
    PAPER_SKILLS,
    Plan,
    Skill,
    paper_plan,
    simulated_answers,
)
from affectsim_data.inspection.figures import INK, figure_class, png_bytes, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DOCS = Path(__file__).resolve().parents[1] / "docs"
_CORRELATIONS = (0.0, 0.1, 0.2, 0.3, 0.5)
_GROUPS = {
    "open": "As good as open models: Macro-F1 9.9 %",
    "closed": "As good as closed models: Macro-F1 22.6 %",
}
_TITLES = {"macro_f1": "Macro-F1", "gain": "gain", "gap": "gap", "ogr": "OGR"}
_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""After Okabe and Ito: told apart by colour-blind readers, too."""
_STYLES = {"performance": ("-", "o"), "episode": (":", "s")}
_LEGEND: dict[str, Any] = {"fontsize": 9, "frameon": False, "labelcolor": INK}
_TESTS = {
    "permutation": "swapping performances",
    "interval": "interval of the gain without 0",
    "mcnemar": "McNemar, over episodes",
}
_PLANS = ((20, 10), (40, 10), (80, 10), (160, 10), (320, 10), (160, 2), (160, 25), (160, 100))
"""Performances, and episodes of each."""

Rows = list[dict[str, Any]]


def coverages(repeats: int) -> Rows:
    """Percent of intervals that hold the truth, by skill, correlation, unit and metric."""
    rows = []
    for group, skill in _skills():
        for unit, count, draws in (("performance", repeats, 500), ("episode", repeats // 4, 200)):
            shares = measure_coverage(
                paper_plan(),
                skill,
                unit="performance" if unit == "performance" else "episode",
                num_repeats=count,
                num_resamples=draws,
                seed=1,
            )
            row: dict[str, Any] = {"models": group, "correlation": skill.correlation, "drawn": unit}
            for metric in STUDY_METRICS:
                row[metric] = 100 * shares[metric]
            rows.append(row)
    return rows


def errors(repeats: int) -> Rows:
    """Percent of studies without a difference in which a test finds one at 5 %."""
    rows = []
    for group, skill in _skills():
        signal = {**skill.signal, "a_obs": skill.signal["p_init"]}
        rates = measure_errors(
            paper_plan(), dataclasses.replace(skill, signal=signal), num_repeats=repeats, seed=2
        )
        percent = {name: 100 * rate for name, rate in dataclasses.asdict(rates).items()}
        rows.append({"models": group, "correlation": skill.correlation, **percent})
    return rows


def detectable(repeats: int) -> Rows:
    """Points of accuracy between p_init and p_ref that plans of other sizes would show."""
    rows = []
    for performances, each in _PLANS:
        plan = Plan.even({"any": (performances, performances * each)}, rng=np.random.default_rng(0))
        row: dict[str, Any] = {"performances": performances, "episodes of each": each}
        for correlation in (0.1, 0.3):
            skill = dataclasses.replace(PAPER_SKILLS["closed"], correlation=correlation)
            row[f"at correlation {correlation}"] = 100 * _effect(plan, skill, repeats // 20)
        rows.append(row)
    return rows


def _effect(plan: Plan, skill: Skill, repeats: int) -> float:
    answers = simulated_answers(plan, skill, np.random.default_rng(0), num_repeats=repeats)
    right = (answers == plan.episode_truth).astype(np.float64)
    conditions = tuple(skill.signal)
    after, before = conditions.index("p_ref"), conditions.index("p_init")
    errors = mean_standard_error(right[:, after] - right[:, before], plan.clusters)
    degrees = effective_clusters(plan.clusters) - 1
    return float(minimum_detectable_effect(np.sqrt((errors**2).mean()), degrees=degrees))


def _skills() -> Iterator[tuple[str, Skill]]:
    for group in _GROUPS:
        for correlation in _CORRELATIONS:
            yield group, dataclasses.replace(PAPER_SKILLS[group], correlation=correlation)


def draw(coverage: Rows, error: Rows) -> Figure:
    """Coverage by correlation for both skills, and below it the errors of tests."""
    figure = figure_class("pictures of coverage")(figsize=(9.0, 7.0), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, height_ratios=(3, 2))
    for column, (group, title) in enumerate(_GROUPS.items()):
        _draw_coverage(panels[0, column], [row for row in coverage if row["models"] == group])
        _draw_errors(panels[1, column], [row for row in error if row["models"] == group])
        panels[0, column].set_title(title, color=INK, fontsize=11)
        panels[1, column].set_xlabel("share of noise that is the performance's own", color=INK)
    panels[0, 0].set_ylabel("intervals that hold the truth, %", color=INK)
    panels[1, 0].set_ylabel("wrongly significant, %", color=INK)
    for unit, (style, marker) in _STYLES.items():  # two grey entries, no points
        panels[0, 1].plot([], [], style, color=INK, marker=marker, label=f"{unit}s drawn")
    panels[0, 0].legend(*_first_entries(panels[0, 0], 4), **_LEGEND, loc="lower left")
    entries = panels[0, 1].get_legend_handles_labels()
    panels[0, 1].legend(entries[0][-2:], entries[1][-2:], **_LEGEND, loc="lower left")
    panels[1, 0].legend(**_LEGEND, loc="upper left")
    return figure


def _draw_coverage(axes: Axes, rows: Rows) -> None:
    axes.axhspan(93, 97, color="#888888", alpha=0.25, linewidth=0)
    for unit, (style, marker) in _STYLES.items():
        mine = [row for row in rows if row["drawn"] == unit]
        for metric, color in zip(_TITLES, _COLORS, strict=True):
            axes.plot(
                [row["correlation"] for row in mine],
                [row[metric] for row in mine],
                style,
                color=color,
                marker=marker,
                markersize=4,
                label=_TITLES[metric],
            )
    axes.set_ylim(35, 101)
    style_axes(axes, grid="y")


def _first_entries(axes: Axes, count: int) -> tuple[list[Any], list[Any]]:
    handles, labels = axes.get_legend_handles_labels()
    return handles[:count], labels[:count]


def _draw_errors(axes: Axes, rows: Rows) -> None:
    axes.axhspan(4, 6, color="#888888", alpha=0.25, linewidth=0)
    styles = (("-", "o", _COLORS[0]), ("-", "o", _COLORS[1]), (":", "s", INK))
    for (name, title), (style, marker, color) in zip(_TESTS.items(), styles, strict=True):
        axes.plot(
            [row["correlation"] for row in rows],
            [row[name] for row in rows],
            style,
            color=color,
            marker=marker,
            markersize=4,
            label=title,
        )
    axes.set_ylim(0, 38)
    style_axes(axes, grid="y")


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """A Markdown table of rows with the same keys."""
    names = list(rows[0])
    lines = [names, ["---"] * len(names)]
    lines += [[_cell(name, row[name]) for name in names] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(name: str, value: float | str) -> str:
    return f"{value:.1f}" if isinstance(value, float) else str(value)


def write_page(page: Path, tables: Mapping[str, str]) -> None:
    """Puts each table between `<!-- NAME start -->` and `<!-- NAME end -->`."""
    text = page.read_text(encoding="utf-8")
    for name, table in tables.items():
        before, rest = text.split(f"<!-- {name} start -->")
        after = rest.split(f"<!-- {name} end -->")[1]
        text = f"{before}<!-- {name} start -->\n{table}\n<!-- {name} end -->{after}"
    page.write_text(text, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=2000, help="simulated studies per number")
    parser.add_argument("--json", type=Path, help="results of a run: read if there, else written")
    options = parser.parse_args()
    if options.json and options.json.is_file():
        results = json.loads(options.json.read_text())
    else:
        results = {
            "coverage": coverages(options.repeats),
            "errors": errors(options.repeats),
            "detectable": detectable(options.repeats),
        }
    if options.json:
        options.json.write_text(json.dumps(results, indent=1) + "\n")
    figure = draw(results["coverage"], results["errors"])
    (_DOCS / "images" / "coverage.png").write_bytes(png_bytes(figure))
    write_page(_DOCS / "statistics.md", {name: markdown(rows) for name, rows in results.items()})
    print("tables in docs/statistics.md, figure in docs/images/coverage.png")


if __name__ == "__main__":
    main()
