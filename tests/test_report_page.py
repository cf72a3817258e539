"""The page of a report: nothing from data becomes markup, and its sentences claim no more."""

from __future__ import annotations

import dataclasses
import math
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from evaluation_cases import HOSTILE_NAMES, evaluation_case
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from affectsim_data.content import content_path
from affectsim_data.evaluation.results import Estimate, Evaluation
from affectsim_data.inspection.figures import svg_bytes
from affectsim_data.reports.figures.models import draw_models
from affectsim_data.reports.page import Example, findings, page_text, write_page
from affectsim_data.reports.page.pictures import inline_svg
from affectsim_data.reports.tables import tables_of

PASSIVE = ("p_mon", "p_ref", "p_init")
VOID = {"meta"}
ELEMENTS = """
    html head meta title style body header main section footer nav h1 h2 h3 p dl div dt dd bdi ul li
    a table thead tbody tr th td small sup strong span figure figcaption details summary
    svg g defs path rect use clippath text tspan
"""
ATTRIBUTES = """
    lang charset http-equiv content name class id href role aria-label tabindex scope colspan dir
    open viewbox d style transform x y width height clip-path
"""


class Page(HTMLParser):
    """What a browser would make of a page, as far as it matters here."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: Counter[str] = Counter()
        self.attributes: list[tuple[str, str, str]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert not self._open, f"left open: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def handle_comment(self, data: str) -> None:
        raise AssertionError(f"comment: {data}")

    @property
    def text(self) -> str:
        """Its words with single spaces."""
        return " ".join("".join(self.words).split())

    def values(self, attribute: str) -> list[str]:
        """What an attribute is, wherever it stands."""
        return [value for _, name, value in self.attributes if name == attribute]


def check_inert(page: Page) -> None:
    """Only elements and attributes we know, which load nothing and run nothing."""
    assert set(page.elements) <= set(ELEMENTS.split())
    assert {name for _, name, _ in page.attributes} <= set(ATTRIBUTES.split())
    assert all(link.startswith("#") for link in page.values("href"))
    names = page.values("id")
    assert len(names) == len(set(names))
    assert {link[1:] for link in page.values("href")} <= set(names)
    for style in [*page.values("style"), *page.values("clip-path")]:
        assert not re.search(r"url\((?!#)|@import|expression|javascript", style, re.IGNORECASE)
    assert page.elements["style"] == page.elements["title"] == page.elements["h1"] == 1
    [policy] = [value for value in page.values("content") if "default-src" in value]
    assert policy.startswith("default-src 'none'; style-src 'unsafe-inline'; img-src data:")


def in_names(evaluation: Evaluation, **changes: str) -> Evaluation:
    """The evaluation with other texts for its model `alpha`, its group, levels and the rest."""

    def renamed(value: Any) -> Any:
        if isinstance(value, str):
            return changes.get(value, value)
        if isinstance(value, tuple):
            return tuple(map(renamed, value))
        if isinstance(value, dict):
            return {renamed(key): renamed(one) for key, one in value.items()}
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            fields = {one.name: getattr(value, one.name) for one in dataclasses.fields(value)}
            return type(value)(**{name: renamed(one) for name, one in fields.items()})
        return value

    changed = renamed(evaluation)
    assert isinstance(changed, Evaluation)
    return changed


BASE = evaluation_case(
    models=("alpha", "beta"), groups={"alpha": "GROUP", "beta": "other"}, notes=["NOTE"]
)
TEXTS = ("alpha", "GROUP", "NOTE", "simulated", "test", "p_mon", "home_1", "simulated_policy")


@pytest.fixture(scope="module")
def plain() -> Page:
    """The page of names that are no markup anywhere."""
    tame = in_names(BASE, **{name: f"plain {place}" for place, name in enumerate(TEXTS)})
    return Page(page_text(tame, tables_of(tame), {}, examples=[Example(*"abcdef")]))


@settings(
    max_examples=10,
    phases=[Phase.explicit, Phase.generate],  # a page is slow to shrink
    suppress_health_check=[HealthCheck.too_slow],
    deadline=None,
)
@given(data=st.data())
def test_no_text_from_data_becomes_markup(plain: Page, data: st.DataObject) -> None:
    hostile = st.sampled_from(HOSTILE_NAMES) | st.text(max_size=30).map("<{}>\"'--><!--".format)
    texts = {name: data.draw(hostile, label=name) for name in TEXTS}
    evaluation = in_names(BASE, **texts)
    example = Example(*(data.draw(hostile) for _ in range(6)))
    text = page_text(evaluation, tables_of(evaluation), {}, examples=[example])
    page = Page(text)
    check_inert(page)
    # Every element is ours: none comes or goes with what a text says.
    assert page.elements == plain.elements


def test_names_in_figures_stay_text_and_names_in_tables_whole() -> None:
    evaluation = evaluation_case(models=HOSTILE_NAMES, conditions=PASSIVE, notes=HOSTILE_NAMES)
    figures = {"models.svg": svg_bytes(draw_models(evaluation, Figure, "all"))}
    page = Page(page_text(evaluation, tables_of(evaluation), figures))
    check_inert(page)
    assert page.elements["svg"] == 1
    assert page.elements["use"] > len(HOSTILE_NAMES)
    assert "script" not in page.elements
    assert page.text.count("<script>alert(1)</script>") >= 3
    assert "[U+202E]" in page.text
    assert not re.search(r"[\x00-\x08\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", page.text)


def test_every_part_is_there_and_headed() -> None:
    evaluation = evaluation_case(notes=["3 predictions are missing and count as wrong"])
    figures = {"models.svg": svg_bytes(draw_models(evaluation, Figure, "all"))}
    said = Example("ep-1", "alpha", "p_ref", "sad", "refusal", "I cannot tell. " * 40)
    text = page_text(evaluation, tables_of(evaluation), figures, examples=[said])
    page = Page(text)
    assert page.text.index("3 predictions are missing") < page.text.index("Findings")
    names = {"findings", "figures", "reading", "tables", "examples", "settings", "published"}
    assert names <= set(page.values("id"))
    for table in tables_of(evaluation):
        assert table.title in page.text
    heads = [value for tag, name, value in page.attributes if (tag, name) == ("th", "scope")]
    assert len(heads) == page.elements["th"]
    [label] = [
        value for tag, name, value in page.attributes if (tag, name) == ("svg", "aria-label")
    ]
    assert label.startswith("Macro-F1 of every model")
    assert ("html", "lang", "en") in page.attributes
    for word in ("Chance", "OGR, observation gap recovery", "Fallback", "not single episodes"):
        assert word in page.text
    quoted = page.text[page.text.index("I cannot tell.") :].split("…")[0]
    assert len(quoted) == 299
    for row in ("angry", "fearful", "happy", "neutral", "sad"):
        assert f"Always {row}" in page.text


def test_a_page_without_a_obs_speaks_of_no_policy() -> None:
    evaluation = evaluation_case(models=("alpha",), conditions=PASSIVE)
    page = Page(page_text(evaluation, tables_of(evaluation), {}))
    check_inert(page)
    for word in ("A-Obs", "OGR", "Fallback", "E-SPL"):
        assert word not in page.text.split("The paper's own rows")[0]
    assert "figures" not in page.values("id")


def test_writing_replaces_the_file_whole_and_says_the_same_again(tmp_path: Path) -> None:
    evaluation = evaluation_case(models=("alpha",))
    path = tmp_path / "report.html"
    path.write_text("old")
    write_page(evaluation, tables_of(evaluation), {}, path)
    first = path.read_bytes()
    assert first.startswith(b"<!doctype html>")
    write_page(evaluation, tables_of(evaluation), {}, path)
    assert path.read_bytes() == first
    assert [one.name for one in tmp_path.iterdir()] == ["report.html"]


SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:l="http://www.w3.org/1999/xlink" {}>{}</svg>'


@pytest.mark.parametrize(
    "inside",
    [
        "<script>alert(1)</script>",
        "<style>*{fill:red}</style>",
        '<image l:href="http://example.org/x.png"/>',
        '<a l:href="javascript:alert(1)"><text>x</text></a>',
        "<foreignObject><p>x</p></foreignObject>",
        '<use l:href="http://example.org/x.svg#a"/>',
        '<g onclick="alert(1)" class="x"/>',
        '<metadata><g id="x"/></metadata>',
    ],
)
def test_pictures_keep_shapes_and_text_only(inside: str) -> None:
    kept = inline_svg(SVG.format('onload="x()"', inside).encode(), "name", label='"<b>')
    page = Page(str(kept))
    assert set(page.elements) <= {"svg", "use", "g"}
    assert {name for _, name, _ in page.attributes} <= {"role", "aria-label"}
    assert page.values("aria-label") == ['"<b>']


def test_pictures_have_names_and_ink_of_their_own() -> None:
    inside = (
        '<defs><clipPath id="c"><rect x="0"/></clipPath><path id="m" d="M 0 0"/></defs>'
        '<g id="axes"/>'
        '<g clip-path="url(#c)"><use l:href="#m" style="stroke: #7a7a7a"/><text>a &lt; b</text></g>'
    )
    kept = inline_svg(SVG.format("", inside).encode(), "models", label="x")
    assert (
        '<g clip-path="url(#models-c)"><use href="#models-m" style="stroke: currentColor"' in kept
    )
    assert kept.count("id=") == 2
    assert "a &lt; b" in kept
    for wrong in (b"<svg", b"<html/>"):
        with pytest.raises(ValueError, match="figure 'models' is no SVG file"):
            inline_svg(wrong, "models", label="x")


def network(
    *, initial: float, reference: float, gap: tuple[float, float], chance: float = 0.2
) -> Evaluation:
    """One model of known scores, each give or take five points."""
    evaluation = evaluation_case(models=("network",), conditions=("p_ref", "p_init"))
    values = {"p_init": initial, "p_ref": reference}
    scores = [
        dataclasses.replace(one, macro_f1=Estimate(value, value - 0.05, value + 0.05))
        for one in evaluation.scores
        for value in [values[one.condition]]
    ]
    benefit = dataclasses.replace(
        evaluation.benefits[0], gap=Estimate(reference - initial, *gap), gain=Estimate(math.nan)
    )
    return dataclasses.replace(evaluation, scores=tuple(scores), benefits=(benefit,), chance=chance)


VIEW = "Seen from the reference view instead of the robot's first pose, network's Macro-F1"


@pytest.mark.parametrize(
    ("evaluation", "main", "chance"),
    [
        (
            network(initial=0.312, reference=0.45, gap=(0.091, 0.184)),
            "rises from 31.2 % to 45.0 % (+13.8 points, 95 % interval 9.1 to 18.4).",
            "every score is above it, with its interval.",
        ),
        (
            network(initial=0.312, reference=0.21, gap=(-0.15, -0.05)),
            "falls from 31.2 % to 21.0 % (-10.2 points, 95 % interval -15.0 to -5.0).",
            "under P-Ref the score is not shown to be better than that.",
        ),
        (
            network(initial=0.2, reference=0.22, gap=(-0.0004, 0.05)),
            "is 22.0 % where it was 20.0 % (+2.0 points, 95 % interval 0.0 to 5.0): the interval "
            "includes 0, so a difference is not shown.",
            "under P-Ref and P-Init the score is not shown to be better than that.",
        ),
        (
            network(initial=0.3, reference=0.4, gap=(math.nan, math.nan)),
            "is 40.0 % where it was 30.0 % (+10.0 points, no interval).",
            "every score is above it, with its interval.",
        ),
    ],
)
def test_the_main_finding_says_what_its_interval_allows(
    evaluation: Evaluation, main: str, chance: str
) -> None:
    first, last = (sentence.replace("\N{MINUS SIGN}", "-") for sentence in findings(evaluation))
    assert first == f"{VIEW} {main}"
    assert last == f"Guessing without looking scores 20.0 % on these episodes; {chance}"


def test_of_several_models_the_mean_and_the_counts_are_told() -> None:
    evaluation = evaluation_case(models=("alpha", "beta", "gamma"))
    gaps = [one.gap for one in evaluation.benefits if one.subset == "all"]
    first, *others = findings(evaluation)
    higher = sum(one.value > 0 for one in gaps)
    count = "All 3" if higher == 3 else f"{higher} of 3"
    assert "the mean Macro-F1 of 3 models rises from" in first
    assert f"{count} models score higher, {sum(one.low > 0 for one in gaps)} with" in first
    assert any("Active observation recovers" in sentence for sentence in others)
    assert not any("nan" in sentence for sentence in (first, *others))


def test_recovery_without_bounds_or_gap_is_said_to_be_so() -> None:
    evaluation = evaluation_case(models=("alpha",))
    for ogr, words in (
        (Estimate(math.nan), "is undefined: the reference view is not above"),
        (Estimate(0.5), "recovers 50 % of the gap to the reference view; the share has no bounded"),
        (Estimate(0.5, -math.inf, math.inf), "the share has no bounded interval"),
        (Estimate(0.5, -0.1, 1.2), "(95 % interval \N{MINUS SIGN}10 to 120 %); the interval"),
        (Estimate(-0.5, -0.9, -0.1), "recovers nothing of the gap"),
    ):
        benefits = tuple(dataclasses.replace(one, ogr=ogr) for one in evaluation.benefits)
        told = findings(dataclasses.replace(evaluation, benefits=benefits))
        assert any(words in sentence for sentence in told)


def test_without_p_init_only_scores_are_told() -> None:
    evaluation = evaluation_case(models=("alpha",), conditions=("p_ref", "p_mon"))
    score = evaluation.score("alpha", "p_ref")
    assert score is not None
    first, _ = findings(evaluation)
    assert first.startswith(f"Macro-F1 is {100 * score.macro_f1.value:.1f} % under P-Ref, ")
    assert first.endswith("Without P-Init there is nothing to compare these with.")


def luminance(color: str) -> float:
    """Relative luminance after WCAG."""
    levels = [int(color[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in levels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_text_stands_out_in_light_and_dark_and_the_style_loads_nothing() -> None:
    style = content_path("cards", "report.css").read_text(encoding="utf-8")
    assert not re.search(r"url\(|@import|https?:", style)
    light, dark = re.findall(r":root \{([^}]*--warn-line[^}]*)\}", style)
    for block in (light, dark):
        colors = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", block))
        for ink in ("ink", "soft", "accent"):
            for paper in ("paper", "tint"):
                low, high = sorted((luminance(colors[ink]), luminance(colors[paper])))
                assert (high + 0.05) / (low + 0.05) >= 4.5, f"{ink} on {paper}"
