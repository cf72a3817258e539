"""Runs of recognizers: every answer once, whatever happens on the way."""

from __future__ import annotations

import hashlib
import json
import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import predicting_cases
import pyarrow.parquet as pq
import pytest
import torch
from predicting_cases import CONDITIONS, Teller, undrawn

from affectsim_data.evaluation.tables import read_predictions
from affectsim_data.loaders import AffectSimDataset, Clip, Sample
from affectsim_data.recognizers import PredictionRun, Reply, open_recognizer, predict
from affectsim_data.recognizers.frames import blinded, frame_strip, frames_sha256
from affectsim_data.releases import Release
from affectsim_data.releases.journals import journal_path
from affectsim_data.schemas import SCHEMAS


def rows_of(out: Path, *, latency: bool = False) -> list[dict[str, Any]]:
    """Rows of a table, without what differs from run to run."""
    rows: list[dict[str, Any]] = read_predictions([out]).table.to_pylist()
    return rows if latency else [{**row, "latency_ms": None} for row in rows]


def run(recognizer: Any, dataset: Any, out: Path, **options: Any) -> PredictionRun:
    return predict(recognizer, dataset, out, progress=False, **options)


@pytest.mark.parametrize("suffix", [".parquet", ".csv", ".jsonl"])
def test_a_table_holds_every_clip_in_the_order_of_the_dataset(
    small: Release, tmp_path: Path, suffix: str
) -> None:
    dataset, drawn = undrawn(small, orbits=2)
    out, teller = tmp_path / f"new/answers{suffix}", Teller(batch_size=3)
    result = run(teller, dataset, out)
    assert (result.num_clips, result.num_new, result.num_failed) == (10, 10, 0)
    assert result.is_complete
    rows = rows_of(out, latency=True)
    names = [*CONDITIONS, "orbit_2m_0deg_1.2m", "orbit_2m_1deg_1.2m"]
    expected = [(f"small/{n}", name) for name in names for n in (4, 5)]
    assert [(row["episode_id"], row["condition"]) for row in rows] == expected
    assert {row["model"] for row in rows} == {"teller"}
    for number, row in enumerate(rows):
        reply = teller.reply(dataset[number])
        assert (row["raw_text"], row["label"]) == (reply.raw_text, reply.label)
        assert row["scores"] == (None if reply.scores is None else list(reply.scores))
        assert row["frames_sha256"] == frames_sha256(dataset[number]["video"])
        told = row["latency_ms"]
        assert told == reply.latency_ms or (reply.latency_ms is None and 0 <= told < 1000)
    assert any(row["label"] for row in rows)
    assert any(row["raw_text"] for row in rows)
    # Drawn scene by scene: each room is entered once for all conditions.
    assert [key[0] for key in drawn[:10]] == ["small/4"] * 5 + ["small/5"] * 5
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_parquet_has_the_columns_of_the_contract(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    run(Teller(), undrawn(small)[0], out)
    assert pq.read_schema(out).remove_metadata().equals(SCHEMAS["predictions"].remove_metadata())


def test_a_run_that_is_done_draws_and_asks_nothing(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    run(Teller(), undrawn(small)[0], out)
    written = out.read_bytes()
    (again, drawn), teller = undrawn(small), Teller()
    result = run(teller, again, out)
    assert (result.num_clips, result.num_new, drawn, teller.num_asked) == (6, 0, [], 0)
    assert out.read_bytes() == written
    fewer = run(teller, undrawn(small, conditions=["p_ref"])[0], out)
    assert (fewer.num_clips, fewer.num_new, out.read_bytes()) == (2, 0, written)


class Failing(Teller):
    """Fails at the n-th clip asked for: raises, or says so."""

    def __init__(self, at: int, error: BaseException | str, *, batch_size: int = 2) -> None:
        super().__init__(batch_size=batch_size)
        self.at, self.error = at, error

    def reply(self, sample: Sample) -> Reply:
        self.at -= 1
        if self.at >= 0:
            return super().reply(sample)
        if isinstance(self.error, str):
            return Reply(error=self.error)
        raise self.error


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ConnectionError("gone")])
def test_an_interrupted_run_goes_on_where_it_was(
    small: Release, tmp_path: Path, error: BaseException
) -> None:
    whole, out = tmp_path / "whole.parquet", tmp_path / "answers.parquet"
    run(Teller(), undrawn(small, orbits=2)[0], whole)
    with pytest.raises(type(error)):
        run(Failing(5, error), undrawn(small, orbits=2)[0], out)
    assert not out.exists()
    assert journal_path(out).exists()
    dataset, drawn = undrawn(small, orbits=2)
    teller = Teller(batch_size=4)
    result = run(teller, dataset, out)
    assert (result.num_clips, result.num_new, teller.num_asked) == (10, 6, 6)
    assert len(drawn) == 6  # what was answered is not drawn again
    assert rows_of(out) == rows_of(whole)
    assert not journal_path(out).exists()


def test_a_clip_that_cannot_be_drawn_costs_no_answer(
    small: Release, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dataset, drawn = undrawn(small)
    draw = predicting_cases.Undrawn._draw

    def breaking(self: Any, place: Any) -> Any:
        if len(drawn) == 4:
            raise OSError("shard is gone")
        return draw(self, place)

    monkeypatch.setattr(predicting_cases.Undrawn, "_draw", breaking)
    out, teller = tmp_path / "answers.parquet", Teller()
    with pytest.raises(OSError, match="shard is gone"):
        run(teller, dataset, out)
    lines = journal_path(out).read_text().splitlines()
    assert sum(len(json.loads(line)) for line in lines[1:]) == teller.num_asked == 4


def test_a_killed_run_loses_at_most_the_batch_it_worked_on(
    small_release_path: Path, small: Release, tmp_path: Path
) -> None:
    out = tmp_path / "answers.parquet"
    script = str(Path(predicting_cases.__file__))
    killed = subprocess.run(
        [sys.executable, script, str(small_release_path), str(out), "6"], check=False
    )
    assert killed.returncode == -9
    teller = Teller()
    result = run(teller, undrawn(small_release_path, orbits=3)[0], out)
    assert (result.num_clips, teller.num_asked) == (12, 6)
    whole = tmp_path / "whole.parquet"
    run(Teller(), undrawn(small, orbits=3)[0], whole)
    assert rows_of(out) == rows_of(whole)


@pytest.mark.parametrize("batches", [1, 2])
def test_a_journal_torn_anywhere_costs_the_torn_batch_alone(
    small: Release, tmp_path: Path, batches: int
) -> None:
    whole, out = tmp_path / "whole.parquet", tmp_path / "answers.parquet"
    run(Teller(), undrawn(small)[0], whole)
    with pytest.raises(ConnectionError):
        run(Failing(2 * batches, ConnectionError()), undrawn(small)[0], out)
    content = journal_path(out).read_bytes()
    last = content.rstrip(b"\n").rfind(b"\n") + 1
    cuts = np.random.default_rng(batches).integers(last + 1, len(content), 8)
    for cut in {last, last + 1, len(content) - 1, *cuts.tolist()}:
        for tail in (b"", b"\0" * 9, b"\0" * 9 + b"\n"):
            journal_path(out).write_bytes(content[:cut] + tail)
            out.unlink(missing_ok=True)
            teller = Teller()
            run(teller, undrawn(small)[0], out)
            assert teller.num_asked == 6 - 2 * (batches - 1)
            assert rows_of(out) == rows_of(whole)


def test_a_torn_beginning_is_a_beginning(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    interrupted(small, out)
    header = journal_path(out).read_bytes().split(b"\n")[0]
    for cut in (0, 1, len(header) - 1, len(header)):
        journal_path(out).write_bytes(header[:cut])
        out.unlink(missing_ok=True)
        assert run(Teller(), undrawn(small)[0], out).num_new == 6


def test_a_journal_damaged_in_its_middle_is_refused(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    with pytest.raises(ConnectionError):
        run(Failing(4, ConnectionError()), undrawn(small)[0], out)
    journal = journal_path(out)
    header, first, second, _ = journal.read_text().split("\n")
    for line in ("{}", "[1]", "[{}]", first[:-1], "happy", "[null]", '[{"episode_id": "small/4"}]'):
        journal.write_text(f"{header}\n{line}\n{second}\n")
        with pytest.raises(ValueError, match=r"partial.jsonl, line 2: not a journal.*--overwrite"):
            run(Teller(), undrawn(small)[0], out)
    journal.write_text(f"{first}\n{second}\n")
    with pytest.raises(ValueError, match="line 1: not a journal"):
        run(Teller(), undrawn(small)[0], out)
    assert run(Teller(), undrawn(small)[0], out, overwrite=True).num_new == 6


def interrupted(small: Release, out: Path) -> None:
    """Leaves a journal."""
    with pytest.raises(ConnectionError):
        run(Failing(2, ConnectionError()), undrawn(small)[0], out)


def finished(small: Release, out: Path) -> None:
    """Leaves a table."""
    run(Teller(), undrawn(small)[0], out)


@pytest.mark.parametrize("before", [interrupted, finished])
def test_answers_of_another_run_are_not_mixed_in(
    small: Release, tmp_path: Path, before: Any
) -> None:
    out = tmp_path / "answers.parquet"
    before(small, out)
    kept = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    others = {
        "other": (Teller("other"), undrawn(small)[0]),
        "'train'": (Teller(), undrawn(small, split="train")[0]),
        "3x8x6": (Teller(), undrawn(small, num_frames=3)[0]),
    }
    for told, (recognizer, dataset) in others.items():
        with pytest.raises(ValueError, match=rf"answers.*{told}.*--out.*--overwrite"):
            run(recognizer, dataset, out)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == kept
    assert run(Teller("other"), undrawn(small)[0], out, overwrite=True).num_new == 6
    assert {row["model"] for row in rows_of(out)} == {"other"}


def test_a_release_of_other_content_is_another_run(
    small: Release, small_release_path: Path, tmp_path: Path
) -> None:
    from small_release import write_release

    out = tmp_path / "answers.parquet"
    finished(small, out)
    write_release(tmp_path / "again")  # the same content elsewhere
    assert run(Teller(), undrawn(tmp_path / "again")[0], out).num_new == 0
    write_release(tmp_path / "other", seed=8)
    with pytest.raises(ValueError, match="release_sha256"):
        run(Teller(), undrawn(tmp_path / "other")[0], out)


@pytest.mark.parametrize("suffix", [".parquet", ".csv", ".jsonl"])
def test_a_table_grows_by_what_is_asked_for_more(
    small: Release, tmp_path: Path, suffix: str
) -> None:
    out, whole = tmp_path / f"answers{suffix}", tmp_path / f"whole{suffix}"
    run(Teller(), undrawn(small, conditions=["p_init"])[0], out)
    teller = Teller()
    assert run(teller, undrawn(small)[0], out).num_new == teller.num_asked == 4
    run(Teller(), undrawn(small)[0], whole)
    assert rows_of(out) == rows_of(whole)


@pytest.mark.parametrize("suffix", [".csv", ".jsonl"])
def test_a_table_that_says_nothing_of_its_clips_is_compared_by_frames(
    small: Release, tmp_path: Path, suffix: str
) -> None:
    out = tmp_path / f"answers{suffix}"
    finished(small, out)
    with pytest.raises(ValueError, match=r"small/4' under p_init was answered from other frames"):
        run(Teller(), undrawn(small, num_frames=3)[0], out)


def test_failures_are_told_not_written_and_asked_again(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    result = run(Failing(4, "content filter"), undrawn(small)[0], out)
    assert (result.num_new, result.num_failed, result.is_complete) == (4, 2, False)
    assert result.failures == (
        "small/5 under p_ref: content filter",
        "small/5 under p_mon: content filter",
    )
    assert len(rows_of(out)) == 4
    teller = Teller()
    again = run(teller, undrawn(small)[0], out)
    assert (again.num_new, again.is_complete, teller.num_asked) == (2, True, 2)
    whole = tmp_path / "whole.parquet"
    finished(small, whole)
    assert rows_of(out) == rows_of(whole)
    assert not journal_path(out).exists()


def test_a_run_without_any_answer_leaves_nothing(small: Release, tmp_path: Path) -> None:
    result = run(Failing(0, "no"), undrawn(small)[0], tmp_path / "answers.parquet")
    assert (result.num_failed, len(result.failures)) == (6, 5)
    assert not list(tmp_path.iterdir())


def test_a_journal_is_in_the_hands_of_one_run(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"

    class Nested(Teller):
        def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
            with pytest.raises(BlockingIOError, match="another process predicts into it"):
                run(Teller(), undrawn(small)[0], out, overwrite=True)
            return super().recognize(samples)

    assert run(Nested(), undrawn(small)[0], out).is_complete


BAD_REPLIES: dict[str, Any] = {
    r"gave 1 replies to 2 clips": lambda: [Reply(label="sad")],
    r"label must be one of angry.*'glad'": lambda: [Reply(label="glad")] * 2,
    r"needs raw_text, a label or an error": lambda: [Reply()] * 2,
    r"scores must be 5 finite": lambda: [Reply(label="sad", scores=(1, 2, 3, 4, math.nan))] * 2,
    r"scores must be 5 ": lambda: [Reply(label="sad", scores=(1.0,))] * 2,
    r"latency_ms must be finite": lambda: [Reply(label="sad", latency_ms=math.inf)] * 2,
    r"raw_text must be text, got 3": lambda: [Reply(raw_text=3)] * 2,  # type: ignore[arg-type]  # the point
}


@pytest.mark.parametrize("message", BAD_REPLIES)
def test_what_is_no_answer_is_an_error_that_names_the_episode(
    small: Release, tmp_path: Path, message: str
) -> None:
    teller = Teller("odd one")
    teller.recognize = lambda samples: BAD_REPLIES[message]()  # type: ignore[method-assign]  # the point
    with pytest.raises(ValueError, match=rf"odd one.*{message}") as caught:
        run(teller, undrawn(small)[0], tmp_path / "answers.parquet")
    assert "'small/4' under p_init" in str(caught.value)


def test_text_that_no_table_can_hold_is_mended(small: Release, tmp_path: Path) -> None:
    texts = iter(["half \ud83d a pair", "", "\0 and \x1b[2J", "x" * 1_000_001, "a", "b"])
    teller = Teller(batch_size=6)
    teller.reply = lambda sample: Reply(raw_text=next(texts))  # type: ignore[method-assign]  # simpler than a class
    out = tmp_path / "answers.parquet"
    result = run(teller, undrawn(small)[0], out)
    told = [row["raw_text"] for row in rows_of(out)]
    assert sorted(told) == sorted(["half ? a pair", "", "\0 and \x1b[2J", "a", "b"])
    assert result.failures[0].endswith("a table holds 1,000,000 bytes")


def test_a_recognizer_is_not_shown_what_tells_the_answer(small: Release, tmp_path: Path) -> None:
    class Curious(Teller):
        def reply(self, sample: Sample) -> Reply:
            assert set(sample) == {"video", "depth", "intrinsics", "time_s"}
            return Reply(label=sample["emotion"])

    with pytest.raises(KeyError, match=r"is given video.*not 'emotion'"):
        run(Curious(), undrawn(small)[0], tmp_path / "answers.parquet")


def test_datasets_that_make_no_table_are_refused(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "answers.parquet"
    dataset = undrawn(small)[0]
    mixed = {
        "twice": dataset + undrawn(small, conditions=["p_ref"])[0],
        "one release, split and clip": dataset + undrawn(small, split="train")[0],
    }
    for message, both in mixed.items():
        with pytest.raises(ValueError, match=message):
            run(Teller(), both, out)
    blind = AffectSimDataset(small, images=False)
    with pytest.raises(ValueError, match="images=True and no transform"):
        run(Teller(), blind, out)
    with pytest.raises(ValueError, match=r"\.parquet, \.csv, \.jsonl"):
        run(Teller(), dataset, tmp_path / "answers.txt")
    with pytest.raises(ValueError, match="batch_size must be"):
        run(Teller(), dataset, out, batch_size=0)
    with pytest.raises(ValueError, match="needs a name"):
        run(Teller(" "), dataset, out)
    assert not list(tmp_path.iterdir())


def test_the_hash_of_frames_is_as_documented() -> None:
    video = torch.arange(2 * 3 * 4 * 5, dtype=torch.uint8).reshape(2, 3, 4, 5)
    expected = hashlib.sha256(b"uint8 2x3x4x5\n" + bytes(range(120))).hexdigest()
    assert frames_sha256(video) == expected
    assert frames_sha256(video.flip(-1).flip(-1)) == expected
    assert frames_sha256(video.permute(0, 1, 3, 2)) != expected
    assert frames_sha256(video.reshape(2, 3, 5, 4)) != expected
    with pytest.raises(ValueError, match=r"uint8 \(num_frames, 3, height, width\)"):
        frames_sha256(video.float())


def test_a_strip_shows_every_frame_as_it_is() -> None:
    video = torch.stack([torch.full((3, 6, 8), 10 * n, dtype=torch.uint8) for n in range(20)])
    strip = frame_strip([video[:9], video[9:]])
    assert strip.size == (8 * 12 - 4, 4 * 10 - 4)
    for number in range(20):
        row, column = (
            (number // 8, number % 8) if number < 9 else (2 + (number - 9) // 8, (number - 9) % 8)
        )
        assert strip.getpixel((column * 12, row * 10)) == (10 * number,) * 3


def test_chance_answers_by_its_seed_and_the_frames(small: Release) -> None:
    (clips, _) = undrawn(small, orbits=40)
    samples = [blinded(clips[number]) for number in range(len(clips))]
    first = open_recognizer("uniform:0").recognize(samples)
    backwards = open_recognizer("uniform:0").recognize(samples[::-1])[::-1]
    assert backwards == first != open_recognizer("uniform:1").recognize(samples)
    counts = np.unique([str(reply.label) for reply in first], return_counts=True)[1]
    assert len(counts) == 5
    assert counts.min() >= 7  # of 86, 17 expected each
    assert {r.label for r in open_recognizer("constant:sad").recognize(samples)} == {"sad"}


@pytest.mark.egl
def test_workers_draw_what_this_process_draws(small_release_path: Path, tmp_path: Path) -> None:
    clip = Clip(num_frames=2, width=16, height=16)
    dataset = AffectSimDataset(small_release_path, condition="p_ref", clip=clip)
    dataset = dataset + AffectSimDataset(small_release_path, condition="p_init", clip=clip)  # type: ignore[assignment]  # a sum
    here, there = tmp_path / "here.parquet", tmp_path / "there.parquet"
    for out, num_workers in ((here, 0), (there, 1)):
        result = run(Teller(), dataset, out, num_workers=num_workers)
        assert result.num_new == 4
    assert rows_of(here) == rows_of(there)
    assert rows_of(here)[0]["frames_sha256"] == frames_sha256(dataset[0]["video"])
    assert len({row["frames_sha256"] for row in rows_of(here)}) == 4
