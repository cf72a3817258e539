"""Raw answers are read as a careful human reads them; order of options and noise change nothing."""

from __future__ import annotations

import functools
import itertools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from affectsim_data.evaluation.answers import Answer, audit_answers, parse_answer, parse_answers
from affectsim_data.evaluation.answers.words import (
    EMOTION_WORDS,
    NEAR_WORDS,
    OUTSIDE_WORDS,
    decisions_table,
    meaning_of,
    words_table,
)
from affectsim_data.evaluation.scored import OUTCOMES, outcome_code
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.motion import Emotion

GOLD = Path(__file__).parent / "goldens" / "answers.jsonl"
DOCS = Path(__file__).parents[1] / "docs" / "answers.md"
FILLERS = (
    "The room has a sofa and two lamps.",
    "The clip lasts four seconds.",
    "The person walks to the door and stops.",
    "There is a table on the left.",
    "Both arms can be seen.",
)
THOUGHTS = (
    "Perhaps angry, perhaps fearful. Let me look again.",
    'The options are A to E. {"emotion": "happy"} would be one way. Final answer: sad?',
    "",
)
emotions = st.sampled_from(EMOTIONS)
orders = st.permutations(EMOTIONS)
FORMS = ("{}", "({})", "{}.", "**{}**", "Option {}", "Answer: {}", "The answer is {}.", "{})")
WRAPPERS = (
    "{}",
    "**{}**",
    "`{}`",
    '"{}"',
    "“{}”",
    "({})",
    "- {}",
    "> {}",
    "### {}",
    "{}!",
    "{}...",
    "  \n\n {} \t\n",
    "```\n{}\n```",
    "\\boxed{{{}}}",
    "$\\boxed{{\\text{{{}}}}}$",
    "<answer>{}</answer>",
    "Final answer: {}",
    '{{"emotion": "{}"}}',
    "{}</s>",
    "<|im_start|>assistant\n{}<|im_end|>",
)


@functools.cache
def gold() -> list[dict[str, Any]]:
    return [json.loads(line) for line in GOLD.read_text(encoding="utf-8").splitlines()]


def of_kinds(*kinds: str) -> list[dict[str, Any]]:
    return [row for row in gold() if row["kind"] in kinds]


def told(answer: Answer) -> str:
    """The label or outcome of an answer."""
    assert (answer.label is None) != (answer.outcome is None)
    assert answer.reason
    return str(answer.label or answer.outcome)


def expected(row: dict[str, Any]) -> str:
    return str(row.get("label") or row["outcome"])


def read(row: dict[str, Any], text: str | None = None) -> str:
    return told(parse_answer(row["text"] if text is None else text, options=row.get("options")))


def test_the_gold_file_is_as_large_and_varied_as_it_says() -> None:
    kinds = {row["kind"] for row in gold()}
    assert len(gold()) >= 1000
    assert len(kinds) >= 15
    assert {expected(row) for row in gold()} == {*EMOTIONS, *OUTCOMES} - {"missing"}
    assert all(sum(expected(row) == emotion for row in gold()) >= 80 for emotion in EMOTIONS)
    texts = [(row["text"], str(row.get("options"))) for row in gold()]
    assert len(set(texts)) == len(texts)
    for row in gold():
        known = EMOTIONS if "label" in row else OUTCOMES
        assert expected(row) in known


@pytest.mark.parametrize("kind", sorted({row["kind"] for row in gold()}))
def test_gold(kind: str) -> None:
    wrong = [
        f"{row['text']!r}: {expected(row)} expected, got {answer}"
        for row in of_kinds(kind)
        if told(answer := parse_answer(row["text"], options=row.get("options"))) != expected(row)
    ]
    assert not wrong


def test_codes_are_those_of_a_scored_table() -> None:
    texts = ["angry", "sad", "happy or sad", "", None, "sad", "a chair", "I cannot tell."]
    codes = parse_answers(texts)
    assert codes.dtype == np.int8
    empty = outcome_code("empty")
    want = [0, 4, outcome_code("ambiguous"), empty, empty, 4]
    assert codes.tolist() == [*want, outcome_code("other"), outcome_code("refusal")]
    assert parse_answers([]).shape == (0,)
    assert parse_answers(["B"], options=("sad", "happy")).tolist() == [2]


def test_each_distinct_text_is_parsed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[parse_answer.__module__]
    seen: list[str | None] = []

    def counted(text: str | None, *, options: Any = None) -> Answer:
        seen.append(text)
        return Answer("sad", None, "counted")

    monkeypatch.setattr(module, "parse_answer", counted)
    assert parse_answers(["a", "b", "a", None, None]).tolist() == [4] * 5
    assert seen == ["a", "b", None]


def test_an_audit_lists_the_commonest_first() -> None:
    rows = audit_answers(["sad", "Hm.", "sad", "D"])
    assert [(count, text, told(answer)) for count, text, answer in rows] == [
        (2, "sad", "sad"),
        (1, "Hm.", "other"),
        (1, "D", "neutral"),
    ]


def test_an_answer_is_a_label_or_an_outcome() -> None:
    with pytest.raises(ValueError, match="a label or an outcome, got None and None"):
        Answer(None, None, "why")
    with pytest.raises(ValueError, match="got 'sad' and 'other'"):
        Answer("sad", "other", "why")


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["sad", "hapy"], r"unknown: \['hapy'\]"),
        (["sad", "sad"], "different words"),
        (["sad"], "2 to 10 different words"),
    ],
)
def test_options_that_are_no_words_are_refused(options: list[str], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        parse_answer("A", options=options)


def test_reasons_say_the_rule_and_the_words() -> None:
    assert "JSON" in parse_answer('{"emotion": "sad"}').reason
    assert "final answer" in parse_answer("Hm. Final answer: sad").reason
    assert "'B' in the options is happy" in parse_answer("B", options=("sad", "happy")).reason
    assert "default order" in parse_answer("B").reason
    assert "'anger'" in parse_answer("It is anger.").reason


WORDS = [(word, name) for name, words in EMOTION_WORDS.items() for word in words.split()]


def test_any_label_word_alone_is_its_label() -> None:
    for word, name in WORDS:
        for text in (word, word.upper(), f"{word.title()}.", f"The emotion is {word}."):
            assert parse_answer(text).label == name, text


def test_words_of_none_of_the_five_are_other() -> None:
    words = " ".join((*OUTSIDE_WORDS, *NEAR_WORDS)).split()
    assert [word for word in words if parse_answer(word).outcome != "other"] == []


def test_no_word_stands_in_two_tables() -> None:
    words = " ".join((*EMOTION_WORDS.values(), *OUTSIDE_WORDS, *NEAR_WORDS)).split()
    assert len(set(words)) == len(words)
    assert all(word == word.casefold() and meaning_of(word) for word in words)


def test_the_tables_of_the_docs_are_those_of_the_code() -> None:
    text = DOCS.read_text(encoding="utf-8")
    assert words_table() in text
    assert decisions_table() in text


def test_the_examples_of_the_docs_come_out() -> None:
    lines = DOCS.read_text(encoding="utf-8").splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| `")]
    cases = [(cells[0].strip("`").replace("⏎", "\n"), cells[1]) for cells in rows]
    assert len(cases) >= 20
    for text, want in cases:
        assert told(parse_answer(text)) == want, text


@given(order=orders, place=st.integers(0, 4), form=st.sampled_from(FORMS), number=st.booleans())
def test_letters_and_numbers_follow_the_options(
    order: list[Emotion], place: int, form: str, number: bool
) -> None:
    sign = str(place + 1) if number else "ABCDE"[place]
    assert parse_answer(form.format(sign), options=order).label == order[place]
    assert parse_answer(form.format(sign)).label == EMOTIONS[place]


@given(
    order=orders, place=st.integers(0, 4), style=st.sampled_from(("{}) {}", "({}) {}", "{}. {}"))
)
def test_letters_follow_the_options_an_answer_states(
    order: list[Emotion], place: int, style: str
) -> None:
    listed = " ".join(style.format(*pair) for pair in zip("ABCDE", order, strict=True))
    text = f"{listed}\nAnswer: {'ABCDE'[place]}"
    for given_order in (None, EMOTIONS):
        assert parse_answer(text, options=given_order).label == order[place]


@given(order=orders, place=st.integers(0, 4), end=st.sampled_from(("{}", "{}.", "Answer: {}")))
def test_an_answer_behind_the_repeated_prompt_counts(
    order: list[Emotion], place: int, end: str
) -> None:
    listed = "\n".join(f"{letter}. {name}" for letter, name in zip("ABCDE", order, strict=True))
    prompt = (
        f"Which emotion does the person express?\n{listed}\nAnswer with one letter or one word."
    )
    for said in ("ABCDE"[place], order[place]):
        text = f"{prompt}\n{end.format(said)}"
        assert parse_answer(text, options=order).label == order[place]
    assert parse_answer(prompt, options=order).outcome == "ambiguous"


@given(order=orders, place=st.integers(0, 4), other=st.integers(0, 4))
def test_a_letter_and_a_word_must_agree(order: list[Emotion], place: int, other: int) -> None:
    said = told(parse_answer(f"{'ABCDE'[place]}. {order[other]}", options=order))
    assert said == (order[place] if place == other else "ambiguous")


@given(order=orders, chosen=emotions)
def test_the_options_repeated_before_an_answer_do_not_count(
    order: list[Emotion], chosen: Emotion
) -> None:
    listed = ", ".join(order)
    assert parse_answer(f"Options: {listed}. Answer: {chosen}").label == chosen
    assert parse_answer(f"From {listed}, I choose {chosen}.").label == chosen
    assert parse_answer(listed).outcome == "ambiguous"


@given(word=st.sampled_from(WORDS), wrapper=st.sampled_from(WRAPPERS), data=st.data())
def test_dressing_changes_nothing(word: tuple[str, Emotion], wrapper: str, data: Any) -> None:
    case = data.draw(st.sampled_from((str, str.upper, str.title, _full_width)))
    assert parse_answer(wrapper.format(case(word[0]))).label == word[1]


def _full_width(text: str) -> str:
    return "".join(chr(ord(sign) + 0xFEE0) if "!" <= sign <= "~" else sign for sign in text)


@given(
    row=st.sampled_from(of_kinds("sentence", "negation", "hedged", "outside", "refusal")),
    before=st.lists(st.sampled_from(("\n", " ", "\t", "\u200b", "\r\n")), max_size=4),
    after=st.lists(st.sampled_from((" ", "\n", "</s>", "\ufeff", "<|im_end|>")), max_size=4),
)
def test_white_space_and_marks_change_nothing(
    row: dict[str, Any], before: list[str], after: list[str]
) -> None:
    text = "".join(before) + row["text"].replace(" ", "  ") + "".join(after)
    assert read(row, text) == expected(row)


@given(
    word=st.sampled_from(WORDS),
    said=st.sampled_from(("The person looks {}.", "The emotion is {}.", "I would say {}.")),
    before=st.lists(st.sampled_from(FILLERS), max_size=3),
    after=st.lists(st.sampled_from(FILLERS), max_size=3),
)
def test_sentences_without_emotions_change_nothing(
    word: tuple[str, Emotion], said: str, before: list[str], after: list[str]
) -> None:
    text = " ".join([*before, said.format(word[0]), *after])
    assert parse_answer(text).label == word[1]


@given(
    row=st.sampled_from(of_kinds("sentence", "negation", "correction", "refusal", "json")),
    after=st.lists(st.sampled_from(FILLERS), min_size=1, max_size=2),
)
def test_sentences_behind_an_answer_change_nothing(row: dict[str, Any], after: list[str]) -> None:
    end = "" if row["text"].rstrip()[-1:] in ".!?" else "\n"
    cut_off = row["kind"] == "json" and row["text"].count("{") != row["text"].count("}")
    if not cut_off and expected(row) != "empty":
        assert read(row, f"{row['text']}{end} {' '.join(after)}") == expected(row)


@given(
    row=st.sampled_from(gold()),
    thought=st.sampled_from(THOUGHTS),
    tag=st.sampled_from(("think", "thinking", "reasoning", "THINK")),
)
@settings(max_examples=150)
def test_a_thinking_block_before_an_answer_changes_nothing(
    row: dict[str, Any], thought: str, tag: str
) -> None:
    text = f"<{tag}>\n{thought}\n</{tag}>\n\n{row['text'] or ''}"
    assert read(row, text) == expected(row)
    assert parse_answer(f"<{tag}>{thought} sad").outcome == "empty"


@given(first=emotions, second=emotions)
def test_two_labels_on_equal_terms_are_ambiguous(first: Emotion, second: Emotion) -> None:
    for text in ("{} or {}", "either {} or {}", "{}/{}", "The person looks {} and {}.", "{}\n{}"):
        said = told(parse_answer(text.format(first, second)))
        assert said == (first if first == second else "ambiguous")


@given(first=emotions, second=emotions)
def test_what_is_denied_does_not_count(first: Emotion, second: Emotion) -> None:
    if first == second:
        return
    for text in (
        "not {} but {}",
        "Not {}, {}.",
        "The person isn't {}; they are {}.",
        "more {1} than {0}",
        "{1} rather than {0}",
        "{1} instead of {0}",
        "I thought {}. Wait, no, {}.",
    ):
        assert parse_answer(text.format(first, second)).label == second, text


@given(scores=st.lists(st.integers(0, 99), min_size=5, max_size=5), order=orders)
def test_the_highest_score_wins_in_any_order(scores: list[int], order: list[Emotion]) -> None:
    by_name = dict(zip(order, scores, strict=True))
    best = [name for name in EMOTIONS if by_name[name] == max(scores)]
    want = best[0] if len(best) == 1 else "ambiguous"
    assert told(parse_answer(json.dumps(by_name))) == want
    assert told(parse_answer(json.dumps({"scores": by_name}, indent=1))) == want
    assert told(parse_answer("\n".join(f"{name}: {by_name[name]}%" for name in order))) == want


SCRAPS = (
    *("sad", "happy", "not", "no", "or", "but", "A", "B)", "(C)", "1.", "2", "{", "}", "[", "]"),
    *(
        '"emotion":',
        ":",
        ",",
        ".",
        "\n",
        "<think>",
        "</think>",
        "\\boxed{",
        "Answer:",
        "Final answer:",
    ),
    *(
        "I cannot determine",
        "```",
        "wait,",
        "than",
        "first",
        "<|channel|>",
        "final",
        "😀",
        "assistant:",
    ),
)
noise = st.one_of(
    st.text(max_size=60), st.lists(st.sampled_from(SCRAPS), max_size=14).map(" ".join)
)


@given(text=noise, order=st.one_of(st.none(), orders))
@settings(max_examples=200)
@example("\ud800", None)
@example("{" * 5000, None)
@example('{"a":' * 5000, None)
@example('{"emotion": ' + "9" * 5000 + "}", None)
@example('{"happy": NaN, "sad": Infinity}', None)
@example("²", None)
@example("\\boxed{", None)
def test_whatever_comes_in_one_answer_comes_out(text: str, order: list[str] | None) -> None:
    answer = parse_answer(text, options=order)
    told(answer)
    assert answer == parse_answer(text, options=order)
    assert answer.code == parse_answers([text], options=order)[0]
    assert answer.label is None or answer.label in EMOTIONS
    assert answer.outcome is None or answer.outcome in OUTCOMES[:4]


REPEATED = (
    *('{"a":', "[", "sad or ", "angry but ", "not sad, ", "1. angry ", "Answer: ", "\\boxed{"),
    *("\n \n", "cannot a", "<think>", "too far ", "no emotion ", '"', "A) ", "sad? ", "{}", "  "),
)


@pytest.mark.parametrize("unit", REPEATED)
def test_work_grows_with_the_text_and_no_faster(unit: str) -> None:
    small, large = (_lines_run(unit * (size // len(unit))) for size in (2_000, 8_000))
    assert large <= 4.6 * small + 500


def _lines_run(text: str) -> int:
    """Lines of Python that one parse executes: a count, not a time."""
    count = 0

    def trace(frame: Any, event: str, argument: Any) -> Any:
        nonlocal count
        if "answers" not in frame.f_code.co_filename:
            return None
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        parse_answer(text)
    finally:
        sys.settrace(before)
    return count


def test_long_answers_are_read_to_their_end() -> None:
    filler = " ".join(itertools.islice(itertools.cycle(FILLERS), 8_000))
    assert len(filler) > 200_000
    assert parse_answer(f"{filler} The person looks sad.").label == "sad"
    assert parse_answer("a" * 300_000 + " " * 300_000 + ":(").outcome == "other"
