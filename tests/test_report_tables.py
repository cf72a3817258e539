"""Tables of reports: the numbers of the evaluation, and names that stay text in every format."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import re
from html.parser import HTMLParser

import pytest
from evaluation_cases import HOSTILE_NAMES, evaluation_case
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from rich.console import Console
from scored_cases import CONDITIONS

from affectsim_data.evaluation.published import PUBLISHED, published_means
from affectsim_data.evaluation.results import Estimate, Evaluation
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports.tables import (
    Cell,
    Column,
    Row,
    Table,
    csv_table,
    latex_table,
    markdown_table,
    print_tables,
    tables_of,
)
from affectsim_data.reports.tables.latex import latex_text
from affectsim_data.reports.tables.markdown import markdown_name
from affectsim_data.reports.tables.published_tables import published_tables
from affectsim_data.reports.tables.spreadsheet import csv_text_cell
from affectsim_data.reports.tables.terminal import print_table
from affectsim_data.reports.tables.texts import DASH, MINUS, cell_text, interval_text, one_line

PAPER_TABLES = ("main_results", "new_observations", "recovery_efficiency", "execution")
GROUPS = {"alpha": "Open", "beta": "Open", "gamma": "Closed"}


@pytest.fixture(scope="module")
def case() -> Evaluation:
    return evaluation_case(groups=GROUPS, parameters={"alpha": "7B"})


def table_of(evaluation: Evaluation, name: str) -> Table:
    return next(table for table in tables_of(evaluation) if table.name == name)


def row_of(table: Table, *keys: str) -> dict[str, Cell]:
    """Cells by column of the row with these names."""
    for row in table.entries:
        if tuple(cell.value for cell in row.cells[: len(keys)]) == keys:
            names = [column.name for column in table.columns]
            return dict(zip(names, row.cells, strict=True))
    raise AssertionError(f"{table.name} has no row {keys}")


def printed(evaluation: Evaluation, width: int, *, brief: bool = False) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=width, force_terminal=False, highlight=False)
    print_tables(evaluation, console, brief=brief)
    return stream.getvalue()


# Numbers


def test_tables_have_names_of_files_and_hold_together(case: Evaluation) -> None:
    tables = tables_of(case)
    names = [table.name for table in tables]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z_]+", name) for name in names)
    assert set(PAPER_TABLES) <= set(names)
    assert {"by_family", "by_challenge", "by_action", "by_emotion", "by_scene"} <= set(names)


def test_main_results_are_the_scores_with_bold_as_in_the_paper(case: Evaluation) -> None:
    table = table_of(case, "main_results")
    for card in case.models:
        row = row_of(table, card.model)
        for condition in case.conditions:
            score = case.score(card.model, condition)
            assert score is not None
            cell = row[condition]
            assert (cell.value, cell.low) == (score.macro_f1.value, score.macro_f1.low)
            is_better = condition == "a_obs" and score.macro_f1.value > row["p_init"].value  # type: ignore[operator]
            assert cell.best == is_better
        benefit = case.benefit(card.model)
        assert benefit is not None
        assert row["gain"].value == benefit.gain.value
    mean = row_of(table, "Open: mean (2)")
    values = [row_of(table, name)["p_ref"].value for name in ("alpha", "beta")]
    assert mean["p_ref"].value == pytest.approx(sum(values) / 2)  # type: ignore[arg-type]


def test_answers_recalls_and_confusions_add_up(case: Evaluation) -> None:
    answers = row_of(table_of(case, "answers"), "alpha", "P-Init")
    outcomes = ("refusal", "ambiguous", "empty", "other", "missing")
    counts = [int(answers[name].value) for name in ("valid", *outcomes)]  # type: ignore[arg-type]
    assert sum(counts) == answers["episodes"].value == 360
    recall = row_of(table_of(case, "recall"), "alpha", "P-Init")
    for emotion in EMOTIONS:
        row = row_of(table_of(case, "confusions"), "alpha", "P-Init", emotion)
        line = [int(row[f"answered_{name}"].value) for name in (*EMOTIONS, "other")]  # type: ignore[arg-type]
        assert recall[emotion].value == line[EMOTIONS.index(emotion)] / sum(line)
        by_emotion = row_of(table_of(case, "by_emotion"), emotion, "alpha")
        assert by_emotion["p_init"].value == pytest.approx(recall[emotion].value)


def test_every_table_of_macro_f1_says_chance(case: Evaluation) -> None:
    names = (
        "summary",
        "main_results",
        "new_observations",
        "answers",
        "by_family",
        "by_challenge",
        "by_action",
    )
    for name in (*names, "by_scene"):
        table = table_of(case, name)
        chance = [row for row in table.rows if str(row.cells[0].value).startswith("Chance")]
        assert len(chance) == 1, name
        assert Cell(case.chance) in chance[0].cells


def test_scores_that_may_be_chance_are_marked() -> None:
    case = evaluation_case(width=0.5)
    row = row_of(table_of(case, "summary"), "alpha")
    assert row["p_ref"].mark == "†"
    assert row_of(table_of(evaluation_case(), "summary"), "alpha")["p_ref"].mark == ""
    without = dataclasses.replace(case.scores[0], macro_f1=Estimate(0.9))
    case = dataclasses.replace(case, scores=(without, *case.scores[1:]))
    assert row_of(table_of(case, "summary"), "alpha")[without.condition].mark == "†"


def test_what_is_not_there_is_a_dash_with_the_reason() -> None:
    case = evaluation_case(without=[("beta", "p_ref")])
    cell = row_of(table_of(case, "main_results"), "beta")["p_ref"]
    assert cell.is_undefined
    assert cell.mark == "a"
    assert row_of(table_of(case, "benefits"), "beta")["ogr"].mark == "a"
    for table in tables_of(case):
        for row in table.entries:
            for undefined in (cell for cell in row.cells if cell.is_undefined):
                assert undefined.mark, table.name


def test_ogr_says_why_it_is_undefined_or_unbounded() -> None:
    case = evaluation_case()
    flat = dataclasses.replace(case.benefits[0], ogr=Estimate(math.nan))
    loose = dataclasses.replace(case.benefits[1], ogr=Estimate(0.5, -math.inf, math.inf))
    case = dataclasses.replace(case, benefits=(flat, loose, *case.benefits[2:]))
    table = table_of(case, "benefits")
    assert row_of(table, "alpha")["ogr"].mark == "b"
    assert row_of(table, "beta")["ogr"].mark == "e"
    assert {mark for mark, _ in table.footnotes} >= {"b", "e"}
    assert "∞]" in interval_text(
        row_of(table, "beta")["ogr"], Column("x", "x", "ratio", "", 2, "shown")
    )


@pytest.mark.parametrize("conditions", [("p_init",), ("p_ref", "p_init"), ("p_ref",), ("mine",)])
def test_any_conditions_make_a_report(conditions: tuple[str, ...]) -> None:
    case = evaluation_case(conditions=conditions, models=("alpha",))
    names = {table.name for table in tables_of(case)}
    assert "recovery_efficiency" not in names
    assert ("benefits" in names) == (conditions == ("p_ref", "p_init"))
    assert printed(case, 80)


def test_paper_rows_come_out_as_printed() -> None:
    """Table 3 through our LaTeX: the numbers, signs and bold type of its 24 rows and 2 means."""
    text = latex_table(next(t for t in published_tables() if t.name == "published_main_results"))
    lines = [line for line in text.splitlines() if line.count("&") == 6]
    cells = [[cell.strip() for cell in line.removesuffix(r"\\").split("&")] for line in lines]
    rows = {
        (name, size): [number.replace("$-$", "-") for number in numbers]
        for name, size, *numbers in cells
    }
    for row in PUBLISHED:
        scores = [f"{row.macro_f1[name]:.2f}" for name in ("p_mon", "p_ref", "p_init", "a_obs")]
        if row.gain > 0:
            scores[3] = rf"\textbf{{{scores[3]}}}"
        assert rows[row.model, row.parameters] == [*scores, f"{row.gain:+.2f}"]
    opened = rows["Open-source mean (19)", ""]
    assert opened == ["10.31", "15.56", "9.89", r"\textbf{11.70}", "+1.81"]
    closed = rows["Closed-source mean (5)", ""]
    assert closed == ["24.44", "30.78", "22.61", r"\textbf{24.26}", "+1.64"]


def test_paper_rows_say_they_are_quoted_and_what_ogr_was() -> None:
    for table in published_tables():
        assert "not to be compared" in table.caption
    main = published_tables()[0]
    assert "20 of the 24 scores under P-Init are below it" in main.caption
    assert "0.320 for the Open-source mean (19); 0.201 for the Closed-source mean" in main.notes[0]
    assert len(published_means()) == 3


# Texts of numbers


def test_numbers_are_rounded_signed_and_parted() -> None:
    points = Column("gain", "Gain", "points", digits=2, interval="shown")
    assert cell_text(Cell(-0.0006), points) == f"{MINUS}0.06"
    assert cell_text(Cell(-0.00001), points) == "0.00"
    assert interval_text(Cell(0.0, -0.012, 0.02), points) == f"[{MINUS}1.20, 2.00]"
    assert interval_text(Cell(0.1), points) == ""
    assert cell_text(Cell(math.nan), points) == DASH
    assert cell_text(Cell(0.0004), Column("p", "p", "p")) == "<0.001"


@given(st.floats(0.0, 1.0))
def test_percent_text_is_near_the_share(share: float) -> None:
    text = cell_text(Cell(share), Column("x", "x", "percent", digits=2))
    assert float(text) == pytest.approx(100 * share, abs=0.005000001)


def test_rows_must_fit_their_columns() -> None:
    with pytest.raises(ValueError, match="a row of role entry must have 1 cells, got 2"):
        Table("x", "X", "", (Column("a", "A"),), (Row((Cell("b"), Cell("c"))),))


# Names from data


def hostile_case() -> Evaluation:
    return evaluation_case(
        models=HOSTILE_NAMES,
        groups={name: HOSTILE_NAMES[place % 3] for place, name in enumerate(HOSTILE_NAMES)},
        parameters=dict(zip(HOSTILE_NAMES, reversed(HOSTILE_NAMES), strict=True)),
        conditions=(*CONDITIONS, "a|b <i>$x$ \\y"),
        notes=HOSTILE_NAMES,
    )


texts = st.text(max_size=40) | st.sampled_from(HOSTILE_NAMES)


@given(texts)
def test_one_line_hides_nothing_and_steers_nothing(text: str) -> None:
    line = one_line(text)
    assert line.isprintable()
    assert len(line.splitlines()) <= 1
    assert one_line(line) == line


@pytest.mark.parametrize("width", [80, 120, 200])
def test_terminal_output_fits_and_has_no_control_characters(width: int) -> None:
    text = printed(hostile_case(), width, brief=True)
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", text)
    # Wide characters take two columns.
    assert all(len(line) <= width for line in text.splitlines())
    assert "[bold red]markup[/]" in text


def test_terminal_shows_intervals_below_numbers_where_there_is_little_room() -> None:
    table = table_of(evaluation_case(), "summary")
    wide, narrow = io.StringIO(), io.StringIO()
    print_table(table, Console(file=wide, width=200))
    print_table(table, Console(file=narrow, width=80))
    row = row_of(table, "alpha")["p_ref"]
    column = next(column for column in table.columns if column.name == "p_ref")
    number, interval = cell_text(row, column), interval_text(row, column)
    assert f"{number} {interval}" in wide.getvalue()
    assert f"{number} {interval}" not in narrow.getvalue()
    assert number in narrow.getvalue()
    assert interval in narrow.getvalue()


def test_long_tables_are_cut_in_a_terminal_and_say_so() -> None:
    stream = io.StringIO()
    print_table(
        table_of(evaluation_case(), "confusions"), Console(file=stream, width=100), max_rows=10
    )
    assert "50 more rows; `affectsim report` writes them all" in stream.getvalue()


def test_brief_prints_the_main_thing_only(case: Evaluation) -> None:
    assert "Recall" not in printed(case, 80, brief=True)
    assert len(printed(case, 80, brief=True).splitlines()) < 60
    assert "Recall" in printed(case, 80)


class Tags(HTMLParser):
    """Names of the elements of a page, and what is linked."""

    def __init__(self) -> None:
        super().__init__()
        self.found: set[str] = set()
        self.links: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.add(tag)
        self.links |= {value or "" for name, value in attrs if name in ("href", "src")}


def test_markdown_has_no_elements_but_ours() -> None:
    text = "\n\n".join(markdown_table(table) for table in tables_of(hostile_case()))
    tags = Tags()
    tags.feed(MarkdownIt("gfm-like", {"linkify": False}).render(text))
    tables = {"table", "thead", "tbody", "tr", "th", "td"}
    assert tags.found <= {"h3", "p", "strong", "em", "br", "code", *tables}
    assert not tags.links


@given(texts)
def test_a_name_in_markdown_is_one_cell_with_all_its_words(text: str) -> None:
    page = (
        MarkdownIt("commonmark")
        .enable("table")
        .render(f"| a | b |\n| --- | --- |\n| {markdown_name(text)} | end |")
    )
    tags = Tags()
    tags.feed(page)
    assert tags.found <= {"table", "thead", "tbody", "tr", "th", "td", "code"}
    assert page.count("<td") == 2
    assert ">end<" in page


@given(texts)
def test_csv_cells_are_no_formulas_and_read_back(text: str) -> None:
    table = Table("x", "X", "", (Column("name", "Name"),), (Row((Cell(text),)),))
    [header, row] = list(csv.reader(io.StringIO(csv_table(table))))
    assert header == ["row", "name"]
    assert row == ["entry", csv_text_cell(text)]
    assert not row[1].startswith(("=", "+", "-", "@", "\t", "\r"))
    assert row[1].removeprefix("'") == one_line(text).removeprefix("'")


def test_csv_holds_full_numbers_and_intervals(case: Evaluation) -> None:
    rows = list(csv.DictReader(io.StringIO(csv_table(table_of(case, "main_results")))))
    score = case.score("alpha", "p_ref")
    assert score is not None
    row = next(row for row in rows if row["model"] == "alpha")
    assert float(row["p_ref"]) == score.macro_f1.value
    assert float(row["p_ref_high"]) == score.macro_f1.high
    assert (row["row"], row["group"], row["parameters"]) == ("entry", "Open", "7B")
    assert {row["row"] for row in rows} == {"entry", "mean", "reference"}


LATEX_TEXT = re.compile(
    r"(?:[A-Za-z0-9 .:;()+/=@,!?À-ÿ-]|\\[{}$&#%_]|\{[\[\]*]\}|\{\}"
    r"|\\text(?:backslash|asciitilde|asciicircum|less|greater|bar|quotedblright|quotesingle"
    r"|asciigrave|endash)\{\}|\\ldots\{\}|\$-\$|\$\^\{\\dagger\}\$|\$\\infty\$)*"
)


@given(texts)
@settings(max_examples=300)
def test_latex_text_is_letters_and_our_commands(text: str) -> None:
    assert LATEX_TEXT.fullmatch(latex_text(text)), latex_text(text)


def test_latex_of_hostile_names_is_balanced_and_has_our_commands_only() -> None:
    ours = {
        *("usepackage", "begin", "end", "centering", "caption", "label", "footnotesize"),
        *(
            "belowcaptionskip",
            "scriptsize",
            "setlength",
            "tabcolsep",
            "resizebox",
            "ifdim",
            "width",
            "linewidth",
        ),
        *("else", "fi", "toprule", "midrule", "bottomrule", "addlinespace", "multicolumn"),
        *("textbf", "emph", "textsuperscript", "dagger", "infty", "ldots", "endfirsthead"),
        *("endhead", "textbackslash", "textasciitilde", "textasciicircum", "textless"),
        *("textgreater", "textbar", "textquotedblright", "textquotesingle", "textasciigrave"),
        "textendash",
    }
    for table in tables_of(hostile_case()):
        text = latex_table(table)
        assert set(re.findall(r"\\([A-Za-z]+)", text)) <= ours, table.name
        bare = re.sub(r"\\[{}%]", "", text)
        assert bare.count("{") == bare.count("}")
        ends = re.findall(r"\\(begin|end)\{(\w+)\}", text)
        assert [name for kind, name in ends if kind == "begin"] == [
            name for kind, name in reversed(ends) if kind == "end"
        ]
        assert text.isascii() or not re.search(r"[^\x00-\xff]", text)
        body = text.split("\\midrule\n", 1)[1].split("\\bottomrule")[0]
        for line in body.splitlines():
            if line.endswith(r"\\") and "multicolumn" not in line:
                unescaped = re.sub(r"\\&", "", line)
                assert unescaped.count("&") == len(table.columns) - 1
