"""The command that has a recognizer answer clips: `predict`."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import tyro

if TYPE_CHECKING:
    from affectsim_data.loaders import ConcatenatedDataset
    from affectsim_data.recognizers import PredictionRun

__all__ = ["predict"]


def predict(
    release: tyro.conf.Positional[str] = "mini",
    *,
    recognizer: str,
    out: Path,
    condition: tuple[str, ...] = ("p_init", "p_ref"),
    trajectories: Path | None = None,
    policy: str | None = None,
    split: str = "test",
    split_by: str = "group",
    where: tuple[str, ...] = (),
    limit: int | None = None,
    frames: int = 8,
    size: int = 224,
    workers: int = 0,
    batch_size: int | None = None,
    device: str | None = None,
    revision: str | None = None,
    option_seed: int | None = None,
    max_new_tokens: int | None = None,
    base_url: str | None = None,
    api_key_env: str | None = None,
    concurrency: int | None = None,
    price_in: float | None = None,
    price_out: float | None = None,
    max_cost: float | None = None,
    option: tuple[str, ...] = (),
    dry_run: bool = False,
    overwrite: bool = False,
) -> int:
    """Have a recognizer name the emotion of every clip, into a prediction table.

    Safe to interrupt: the same command goes on where it was. Clips without an answer are told, the
    status is 1 then, and the same command asks for these alone.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        recognizer: network:FILE.safetensors, openai:MODEL, transformers:MODEL_OR_FOLDER,
            constant:EMOTION, uniform:SEED, or module:PACKAGE.MODULE:NAME for one of yours.
        out: The table: .parquet, .csv or .jsonl.
        condition: One or more: p_init p_ref p_mon a_obs.
        trajectories: What a_obs shows, a table that `acquire` made; else that of the release.
        policy: Whose trajectories, where there are those of several.
        split: train, validation or test.
        split_by: What no two splits share: group (performers, performances), scene, or both.
        where: Only episodes of which all this holds: emotion=sad,angry visible_share_init<0.3
        limit: Only so many episodes, the first ones.
        frames: Of a clip, evenly spaced.
        size: Of a frame, pixels; frames are square.
        workers: Processes that draw; 0 for this one.
        batch_size: Clips at once; what the recognizer likes if not given.
        device: Where a network or a transformers model runs: cpu, cuda, cuda:1.
        revision: Of a transformers model on the Hub: commit, tag or branch.
        option_seed: Has vision-language models given the five emotions in another order.
        max_new_tokens: Longest answer of a vision-language model.
        base_url: Of an endpoint: http://localhost:8000/v1
        api_key_env: Environment variable with the key of an endpoint.
        concurrency: Requests to an endpoint at a time.
        price_in: What an endpoint charges for a million tokens it reads, USD; goes with price_out.
        price_out: The same for those it writes.
        max_cost: USD after which an endpoint is asked no more.
        option: More options of the recognizer as NAME=VALUE, the value text or JSON; for endpoints
            temperature=unset, token_field=max_tokens, extra_body={"reasoning_effort":"low"} ...
        dry_run: Say what would be done, with the question, frames, cost and time; ask nothing.
        overwrite: Forget the answers that are there.
    """
    from affectsim_data.recognizers import dry_runs, open_recognizer
    from affectsim_data.recognizers import predict as run_predict
    from affectsim_data.recognizers.endpoint import EndpointStoppedError

    options = {
        "device": device,
        "revision": revision,
        "option_seed": option_seed,
        "max_new_tokens": max_new_tokens,
        "base_url": base_url,
        "api_key_env": api_key_env,
        "concurrency": concurrency,
        "prices": _prices(price_in, price_out),
        "max_cost_usd": max_cost,
    }
    options |= _more_options(option, options)
    runs = _Runs(trajectories, policy)
    dataset = _dataset(release, condition, runs, split, split_by, where, limit, frames, size)
    if dry_run:
        print("\n".join(dry_runs.dry_run(recognizer, dataset, out, **options)))
        return 0
    opened: Any = open_recognizer(recognizer, **options)
    try:
        run = run_predict(
            opened,
            dataset,
            out,
            overwrite=overwrite,
            batch_size=batch_size,
            num_workers=workers,
        )
    except EndpointStoppedError as error:
        print(f"affectsim: {error}", file=sys.stderr)
        return 1
    finally:
        if hasattr(opened, "usage"):
            print("\n".join(opened.usage.lines()))
    print(_summary(run))
    for failure in run.failures:
        print(f"affectsim: no answer: {failure}", file=sys.stderr)
    return 0 if run.is_complete else 1


class _Runs(NamedTuple):
    """What a_obs shows."""

    trajectories: Path | None
    policy: str | None

    def of(self, condition: str) -> dict[str, Any]:
        """As a dataset of that condition takes it."""
        return self._asdict() if condition == "a_obs" else {}


def _dataset(
    release: str,
    conditions: tuple[str, ...],
    runs: _Runs,
    split: str,
    split_by: str,
    where: tuple[str, ...],
    limit: int | None,
    frames: int,
    size: int,
) -> ConcatenatedDataset:
    """The clips meant, condition after condition."""
    from affectsim_data.loaders import AffectSimDataset, Clip, concatenate
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where
    from affectsim_data.releases.joined_splits import as_split_by

    if not conditions:
        raise ValueError("--condition takes one or more, such as p_init p_ref")
    if limit is not None and limit < 1:
        raise ValueError(f"--limit must be from 1 up, got {limit}")
    if not 16 <= size <= 4096:
        raise ValueError(f"--size must be 16 to 4096 pixels, got {size}")
    if runs != _Runs(None, None) and "a_obs" not in conditions:
        raise ValueError("--trajectories and --policy go with --condition a_obs")
    opened = open_release(release)
    parts = [
        AffectSimDataset(
            opened,
            split=split,
            split_by=as_split_by(split_by),
            condition=condition,
            **runs.of(condition),
            clip=Clip(num_frames=frames, width=size, height=size, name=f"{frames}x{size}"),
            filter=parse_where(where) if where else None,
        )
        for condition in conditions
    ]
    return concatenate(part if limit is None else part.subset(slice(limit)) for part in parts)


def _more_options(texts: tuple[str, ...], others: Mapping[str, Any]) -> dict[str, Any]:
    """Options given as NAME=VALUE; what is no JSON is text."""
    found: dict[str, Any] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise ValueError(f"--option takes NAME=VALUE, such as temperature=unset, got {text!r}")
        if name in found or others.get(name) is not None:
            raise ValueError(f"--option {name}: is given twice")
        try:
            found[name] = json.loads(value)
        except json.JSONDecodeError:
            found[name] = value
    return found


def _prices(price_in: float | None, price_out: float | None) -> Any:
    if price_in is None and price_out is None:
        return None
    if price_in is None or price_out is None:
        raise ValueError("--price-in and --price-out go together; give 0 for what costs nothing")
    from affectsim_data.recognizers.endpoint import Prices

    return Prices(price_in, price_out)


def _summary(run: PredictionRun) -> str:
    if run.is_complete and not run.num_new:
        return f"{run.path}: all {run.num_clips:,} clips were answered before; nothing to do"
    before = run.num_clips - run.num_new - run.num_failed
    told = [f"{run.num_new:,} clips answered in {run.elapsed_s:,.0f} s"]
    told += [f"{before:,} before"] if before else []
    if run.num_failed:
        told.append(f"{run.num_failed:,} without an answer: the same command asks for these alone")
    return f"{run.path}: {'; '.join(told)}"
