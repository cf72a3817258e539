"""`affectsim predict`: from a line to a table, a dry run to look at, and errors one can mend."""

from __future__ import annotations

import contextlib
import textwrap
from pathlib import Path
from typing import Any

import pytest
import torch
import tyro
from PIL import Image
from predicting_cases import Undrawn

import affectsim_data.loaders
from affectsim_data.cli.predicting import _more_options, predict
from affectsim_data.evaluation.tables import read_predictions
from affectsim_data.recognizers import open_recognizer, recognizer_kinds
from affectsim_data.recognizers.prompts import PROMPT_VERSION, option_order, prompt_tag, question


def command(*words: object) -> int:
    """The command, called as from a shell."""
    return tyro.cli(predict, args=[str(word) for word in words])


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """Has clips made of noise; what is drawn is in the list."""
    keys: list[tuple[str, str]] = []
    monkeypatch.setattr(Undrawn, "drawn", keys, raising=False)
    monkeypatch.setattr(affectsim_data.loaders, "AffectSimDataset", Undrawn)
    return keys


def test_several_conditions_make_one_table(
    small_release_path: Path,
    tmp_path: Path,
    drawn: list[tuple[str, str]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "answers.csv"
    line = (small_release_path, "--recognizer", "uniform:1", "--out", out)
    assert command(*line, "--condition", "p_init", "p_mon", "--limit", 1) == 0
    assert "2 clips answered" in capsys.readouterr().out
    assert command(*line, "--condition", "p_init", "p_mon") == 0
    told = capsys.readouterr().out
    assert "2 clips answered" in told
    assert "; 2 before" in told
    table = read_predictions([out])
    assert table.models == ("uniform:1",)
    assert table.conditions == ("p_mon", "p_init")
    assert table.table.num_rows == 4
    assert command(*line) == 0  # p_init p_ref
    assert read_predictions([out]).table.num_rows == 6
    drawn.clear()
    assert command(*line) == 0
    assert "all 4 clips were answered before; nothing to do" in capsys.readouterr().out
    assert len(drawn) <= 1  # to compare the frames of a CSV file


def test_where_frames_and_size_choose_the_clips(
    small_release_path: Path, tmp_path: Path, drawn: list[tuple[str, str]]
) -> None:
    out = tmp_path / "answers.parquet"
    line = (small_release_path, "--recognizer", "constant:sad", "--out", out, "--frames", "3")
    assert command(*line, "--condition", "p_ref", "--where", "emotion=sad", "--size", 32) == 0
    assert drawn == [("small/5", "p_ref")]
    with pytest.raises(ValueError, match=r"clip '3x32x32', here '3x224x224'"):
        command(*line, "--condition", "p_ref")


def test_a_recognizer_of_the_users_answers(
    small_release_path: Path,
    tmp_path: Path,
    drawn: list[tuple[str, str]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "own_recognizer.py").write_text(
        textwrap.dedent("""
        from affectsim_data.recognizers import Reply

        class Choosy:
            name, batch_size = "choosy", 4

            def recognize(self, samples):
                return [Reply(error="no mood"), *[Reply(raw_text="Happy!")] * (len(samples) - 1)]
        """)
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    out = tmp_path / "answers.jsonl"
    line = (small_release_path, "--recognizer", "module:own_recognizer:Choosy", "--out", out)
    assert command(*line) == 1
    told = capsys.readouterr()
    assert "3 clips answered" in told.out
    assert "1 without an answer: the same command asks for these alone" in told.out
    assert "no answer: small/4 under p_init: no mood" in told.err
    assert len(drawn) == 4
    command(*line)
    assert drawn[4:] == [("small/4", "p_init")]


def test_a_dry_run_says_what_would_be_done_and_does_not(
    small_release_path: Path,
    tmp_path: Path,
    drawn: list[tuple[str, str]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    out = tmp_path / "answers.parquet"
    line = [small_release_path, "--recognizer", "openai:some-model", "--out", out, "--dry-run"]
    line += ["--size", 16, "--option-seed", 1, "--price-in", 1, "--price-out", 2]
    assert command(*line) == 0
    told = capsys.readouterr().out
    assert "clips       4: p_init, p_ref; 8 frames of 16 x 16" in told
    assert textwrap.indent(question(option_order(1), num_frames=8), "    ") in told
    assert "requests  4," in told
    assert "USD" in told
    assert [path.name for path in tmp_path.iterdir()] == ["answers.frames.png"]
    assert Image.open(tmp_path / "answers.frames.png").size == (8 * 20 - 4, 2 * 20 - 4)
    assert drawn == [("small/4", "p_init"), ("small/4", "p_ref")]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nothing"], r"must be one of network:FILE.*module:PACKAGE.MODULE:NAME, got 'nothing'"),
        (["my.module:Own"], "for a class of yours: module:my.module:Own"),
        (["constant:glad"], "must be one of angry.*got 'glad'"),
        (["uniform:x"], "takes a seed.*got 'x'"),
        (["module:json"], "must be module:PACKAGE.MODULE:NAME"),
        (["module:no_such_thing:X"], "no module 'no_such_thing'.*PYTHONPATH"),
        (["module:json:X"], "json has no 'X'"),
        (["module:json:dumps"], "."),
        (["module:json:JSONDecoder"], "is no recognizer, it lacks name, batch_size, recognize"),
        (["constant:sad", "--device", "cpu"], "does not go with device; it takes no options"),
        (["network:x", "--base-url", "http://x"], "does not go with base_url; it takes device"),
        (["constant:sad", "--price-in", "1"], "--price-in and --price-out go together"),
        (
            ["openai:m", "--base-url", "http://localhost:1/v1", "--option", "glow=1"],
            "with glow; it",
        ),
        (["openai:m", "--option", "glow"], "takes NAME=VALUE.*got 'glow'"),
        (["openai:m", "--concurrency", "2", "--option", "concurrency=3"], "is given twice"),
        (["constant:sad", "--limit", "0"], "--limit must be from 1 up"),
        (["constant:sad", "--size", "8"], "--size must be 16 to 4096"),
        (["constant:sad", "--condition", "p_best"], "condition must be one of"),
        (["constant:sad", "--split", "dev"], "dev"),
        (["network:/no/such/file.safetensors"], "/no/such/file.safetensors"),
    ],
)
def test_errors_say_what_there_is(
    small_release_path: Path, tmp_path: Path, words: list[str], message: str
) -> None:
    with pytest.raises((ValueError, OSError, TypeError), match=message):
        command(small_release_path, "--out", tmp_path / "x.parquet", "--recognizer", *words)
    assert not list(tmp_path.iterdir())


def test_options_of_an_endpoint_may_be_json_text_or_unset() -> None:
    recognizer: Any = open_recognizer(
        "openai:thinker",
        base_url="http://localhost:1/v1",
        **_more_options(
            ("temperature=unset", "seed=unset", 'extra_body={"reasoning_effort": "low"}'), {}
        ),
    )
    with contextlib.closing(recognizer):
        assert "reasoning_effort" in recognizer.name
        frames = torch.zeros((1, 3, 16, 16), dtype=torch.uint8)
        body = recognizer.request_body({"video": frames})
    assert "temperature" not in body
    assert body["reasoning_effort"] == "low"


def test_orders_of_options_are_told_apart_by_name() -> None:
    orders = {option_order(seed) for seed in range(20)}
    assert len(orders) > 10
    assert all(sorted(order) == sorted(option_order()) for order in orders)
    assert len({prompt_tag(order) for order in orders}) == len(orders)
    for options in (("sad",), ("sad",) * 5):
        with pytest.raises(ValueError, match="each once"):
            question(options, num_frames=8)
    with pytest.raises(ValueError, match="one picture or more"):
        question(num_frames=0)
    assert "picture is a frame" in question(num_frames=1)
    assert "pictures" not in question(num_frames=1)


def test_the_page_has_the_question_word_for_word() -> None:
    page = (Path(__file__).parents[1] / "docs/recognizers.md").read_text(encoding="utf-8")
    assert textwrap.indent(question(num_frames=8), "    ") in page
    assert f"`prompt {PROMPT_VERSION}`" in page
    kinds = [kind.partition(":")[0] for kind in recognizer_kinds()]
    assert [kind for kind in kinds if f"`{kind}:" not in page] == []


@pytest.mark.parametrize("spec", ["constant:happy", "uniform:7"])
def test_chance_is_opened_by_name(spec: str) -> None:
    assert open_recognizer(spec).name == spec
