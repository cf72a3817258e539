"""Clips go to an endpoint as they are, and answers come back in order."""

from __future__ import annotations

import ast
import asyncio
import dataclasses
import json
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from endpoint_server import (
    Endpoint,
    Seen,
    answer,
    answer_number,
    fail,
    grey_clip,
    serve_endpoint,
)
from predicting_cases import undrawn
from pydantic import TypeAdapter

from affectsim_data.errors import MissingExtraError
from affectsim_data.evaluation.tables import read_predictions
from affectsim_data.loaders import Sample
from affectsim_data.motions import EMOTIONS
from affectsim_data.recognizers import Recognizer, predict
from affectsim_data.recognizers import endpoint as endpoint_package
from affectsim_data.recognizers.endpoint import EndpointRecognizer, EndpointStoppedError
from affectsim_data.recognizers.endpoint.addresses import DEFAULT_BASE_URL, find_address
from affectsim_data.recognizers.endpoint.frames import encode_frames, frames_of
from affectsim_data.recognizers.prompts import PROMPT_VERSION, option_order, question
from affectsim_data.releases import Release

KEY = "sk-secret-of-the-tests"


@pytest.fixture
def endpoint() -> Iterator[Endpoint]:
    with serve_endpoint() as served:
        yield served


@pytest.fixture(autouse=True)
def no_key_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("OPENAI_API_KEY", "OPENAI_BASE_URL"):
        monkeypatch.delenv(name, raising=False)


def recognizer(endpoint: Endpoint, **options: Any) -> EndpointRecognizer:
    return EndpointRecognizer("model", base_url=endpoint.url, api_key=KEY, **options)


def smooth_clip(num_frames: int = 4) -> Sample:
    """Frames that differ, in colours that tell RGB from BGR."""
    ramp = np.linspace(0.0, 180.0, 64)
    video = np.zeros((num_frames, 3, 48, 64), np.uint8)
    for number in range(num_frames):
        video[number, 0] = ramp
        video[number, 1] = 40 * number
        video[number, 2] = 20
    return cast(Sample, {"video": torch.from_numpy(video)})


def test_the_model_is_asked_our_question_about_these_frames(endpoint: Endpoint) -> None:
    sample = smooth_clip()
    with recognizer(endpoint) as asked:
        (reply,) = asked.recognize([sample])
    (seen,) = endpoint.seen
    assert reply.raw_text == "happy"
    assert reply.label is None
    assert reply.latency_ms is not None
    assert reply.latency_ms > 0
    assert seen.path == "/v1/chat/completions"
    assert seen.headers["authorization"] == f"Bearer {KEY}"
    assert seen.question == question(num_frames=4)
    assert [part["type"] for part in seen.content] == [*["image_url"] * 4, "text"]
    settings = {name: value for name, value in seen.body.items() if name != "messages"}
    assert settings == {"model": "model", "temperature": 0.0, "seed": 0, "max_tokens": 256}
    sent = np.stack(seen.frames).astype(int)
    assert np.abs(sent - frames_of(sample)).max() <= 6  # of JPEG at quality 90


def test_what_is_shown_beforehand_is_what_is_sent(endpoint: Endpoint) -> None:
    with recognizer(endpoint, extra_body={"reasoning_effort": "low"}, detail="low") as asked:
        body = asked.request_body(smooth_clip())
        assert not endpoint.seen
        asked.recognize([smooth_clip()])
    assert endpoint.seen[0].body == body
    assert body["reasoning_effort"] == "low"
    assert body["messages"][0]["content"][0]["image_url"]["detail"] == "low"


def test_requests_are_of_the_form_the_client_library_documents() -> None:
    chat: Any = pytest.importorskip("openai.types.chat.completion_create_params")
    shape: Any = TypeAdapter(chat.CompletionCreateParamsNonStreaming)
    body = recognizer_of("m", detail="high", extra_body={"reasoning_effort": "low"}).request_body(
        smooth_clip()
    )
    checked = shape.validate_python(body, strict=True, extra="forbid")
    assert checked["model"] == "m"
    kinds = [part["type"] for message in checked["messages"] for part in message["content"]]
    assert kinds == [*["image_url"] * 4, "text"]


def test_equal_frames_are_equal_bytes_and_are_all_sent(endpoint: Endpoint) -> None:
    frames = frames_of(grey_clip(3, num_frames=3))
    encoded = encode_frames(frames)
    assert len({*encoded, *encode_frames(frames.copy())}) == 1
    with recognizer(endpoint) as asked:
        asked.recognize([grey_clip(3, num_frames=3)])
    assert len(endpoint.seen[0].frames) == 3


def test_larger_frames_are_made_smaller_on_request() -> None:
    frames = frames_of(smooth_clip(1))
    body = recognizer_of("x", max_side=32).request_body(smooth_clip(1))
    assert len(encode_frames(frames, quality=20)[0]) < len(encode_frames(frames)[0])
    assert Seen("", {}, body).frames[0].shape == (24, 32, 3)


def recognizer_of(model: str, **options: Any) -> EndpointRecognizer:
    return EndpointRecognizer(model, base_url="http://localhost:1/v1", **options)


def test_answers_come_in_the_order_of_clips_whatever_their_pace(endpoint: Endpoint) -> None:
    endpoint.usual = answer_number()
    endpoint.acts = {0: [answer("clip 0", after_s=0.15)], 5: [answer("clip 5", after_s=0.1)]}
    with recognizer(endpoint, concurrency=4) as asked:
        replies = asked.recognize([grey_clip(number) for number in range(12)])
    assert [reply.raw_text for reply in replies] == [f"clip {number}" for number in range(12)]


def test_requests_are_parallel_and_bounded(endpoint: Endpoint) -> None:
    together = threading.Barrier(3, timeout=5.0)

    def act(handler: Any, seen: Any) -> None:
        together.wait()  # breaks, and the test fails, unless three requests are there at once
        answer()(handler, seen)

    endpoint.usual = act
    with recognizer(endpoint, concurrency=3) as asked:
        replies = asked.recognize([grey_clip(number) for number in range(9)])
        assert asked.batch_size == 12
    assert [reply.raw_text for reply in replies] == ["happy"] * 9
    assert endpoint.most_in_flight == 3


def test_a_slow_clip_holds_up_no_other(endpoint: Endpoint) -> None:
    others = threading.Event()

    def slow(handler: Any, seen: Any) -> None:
        assert others.wait(5.0)
        answer("slow")(handler, seen)

    def count(handler: Any, seen: Any) -> None:
        answer()(handler, seen)
        if len(endpoint.seen) == 8:
            others.set()

    endpoint.acts, endpoint.usual = {0: [slow]}, count
    with recognizer(endpoint, concurrency=2) as asked:
        replies = asked.recognize([grey_clip(number) for number in range(8)])
    assert [reply.raw_text for reply in replies] == ["slow", *["happy"] * 7]


def test_connections_stay_open_between_batches(endpoint: Endpoint) -> None:
    ports = set()

    def act(handler: Any, seen: Any) -> None:
        ports.add(handler.client_address[1])
        answer()(handler, seen)

    endpoint.usual = act
    with recognizer(endpoint, concurrency=1) as asked:
        for number in range(3):
            asked.recognize([grey_clip(number)])
    assert len(ports) == 1


def test_it_can_be_closed_and_used_again(endpoint: Endpoint) -> None:
    asked = recognizer(endpoint)
    for _ in range(2):
        assert asked.recognize([grey_clip(1)])[0].raw_text == "happy"
        asked.close()
        asked.close()
    assert asked.usage.answered == 2
    assert not [thread for thread in threading.enumerate() if thread.name == "endpoint"]


def test_a_loop_that_runs_already_is_no_hindrance(endpoint: Endpoint) -> None:
    async def cell() -> str | None:
        with recognizer(endpoint) as asked:
            return asked.recognize([grey_clip(1)])[0].raw_text

    assert asyncio.run(cell()) == "happy"


def test_another_order_of_options_is_asked_and_understood(endpoint: Endpoint) -> None:
    order = option_order(1)
    endpoint.usual = answer("B")
    with recognizer(endpoint, options=order) as asked:
        (reply,) = asked.recognize([grey_clip(0)])
        assert "-".join(order) in asked.name
    assert endpoint.seen[0].question == question(order, num_frames=2)
    assert (reply.raw_text, reply.label) == ("B", order[1])
    assert order[1] != EMOTIONS[1]


def test_the_name_says_what_changes_answers() -> None:
    assert recognizer_of("qwen/vl").name == f"openai:qwen/vl (prompt {PROMPT_VERSION})"
    changed: list[dict[str, Any]] = [
        {"quality": 80},
        {"max_side": 112},
        {"detail": "low"},
        {"temperature": None},
        {"temperature": 0.7},
        {"seed": 3},
        {"max_tokens": 2000},
        {"extra_body": {"reasoning_effort": "low"}},
        {"extra_body": {"chat_template_kwargs": {"enable_thinking": False}}},
        {"extra_body": {"guided_choice": ["angry", "fearful", "happy", "neutral", "sad"] * 2}},
        {"options": option_order(1)},
    ]
    names = [recognizer_of("m", **options).name for options in changed]
    assert len({recognizer_of("m").name, *names}) == len(names) + 1
    assert max(map(len, names)) < 90
    same: list[dict[str, Any]] = [{"concurrency": 1}, {"timeout_s": 5.0}, {"api_key": "another"}]
    assert {recognizer_of("m", **options).name for options in same} == {recognizer_of("m").name}


def test_it_is_a_recognizer() -> None:
    asked: Recognizer = recognizer_of("m")
    assert asked.batch_size == 32


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quality": 0}, "quality must be 1 to 100, got 0"),
        ({"max_side": 4}, "max_side must be at least 8 pixels"),
        ({"concurrency": 0}, "concurrency must be at least 1"),
        ({"timeout_s": 0.0}, "timeout_s positive"),
        ({"temperature": 3.0}, "temperature must be 0 to 2 or None"),
        ({"max_tokens": 0}, "max_tokens must be at least 1"),
        ({"extra_body": {"messages": []}}, "extra_body may not hold messages"),
        ({"extra_body": {"x": {1, 2}}}, "extra_body must be JSON"),
        ({"options": ("happy",)}, "options must be angry"),
        ({"max_cost_usd": 1.0}, "needs prices"),
    ],
)
def test_options_out_of_range_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        recognizer_of("m", **options)


def test_samples_without_frames_are_refused_before_anything_is_sent(endpoint: Endpoint) -> None:
    with recognizer(endpoint) as asked:
        with pytest.raises(ValueError, match="images=True"):
            asked.recognize([grey_clip(0), cast(Sample, {})])
        floats = cast(Sample, {"video": torch.zeros((2, 3, 8, 8))})
        with pytest.raises(ValueError, match=r"must be uint8 .* got float32 \(2, 3, 8, 8\)"):
            asked.recognize([floats])
    assert not endpoint.seen


def test_no_clips_are_no_requests(endpoint: Endpoint) -> None:
    with recognizer(endpoint) as asked:
        assert asked.recognize([]) == []
    assert not endpoint.seen


class TestAddresses:
    def test_the_key_is_of_the_environment(self, monkeypatch: pytest.MonkeyPatch) -> None:
        with pytest.raises(ValueError, match="environment variable OPENAI_API_KEY"):
            find_address()
        monkeypatch.setenv("OPENAI_API_KEY", KEY)
        monkeypatch.setenv("OTHER", "sk-other")
        assert find_address().base_url == DEFAULT_BASE_URL
        assert find_address().api_key == KEY
        assert find_address(api_key_env="OTHER").api_key == "sk-other"
        assert find_address(api_key="given").api_key == "given"
        monkeypatch.setenv("OPENAI_BASE_URL", "http://box:1/v1/")
        assert find_address().base_url == "http://box:1/v1"

    @pytest.mark.parametrize(
        "host", ["localhost", "127.0.0.1", "[::1]", "10.1.2.3", "192.168.0.2", "vllm", "box.local"]
    )
    def test_the_local_network_needs_no_key(self, host: str) -> None:
        assert find_address(f"http://{host}:8000/v1").base_url == f"http://{host}:8000/v1"

    @pytest.mark.parametrize(
        ("url", "message"),
        [
            ("http://example.org/v1", "in the clear"),
            ("https://me:pass-word@example.org/v1", "no user, password"),
            ("https://example.org/v1?key=pass-word", "no user, password, query"),
            ("ftp://example.org", "must be like http"),
            ("example.org/v1", "must be like http"),
            ("https://example.org/v1/chat/completions", "must end before"),
            ("http://box:port/v1", "must be an http or https URL"),
            ("https://", "must be like http"),
            ("https://a box/v1", "without spaces"),
        ],
    )
    def test_urls_that_cannot_be_right_are_refused(self, url: str, message: str) -> None:
        with pytest.raises(ValueError, match=message) as caught:
            find_address(url, KEY)
        assert KEY not in str(caught.value)
        assert "pass-word" not in str(caught.value)

    def test_the_key_is_not_shown(self) -> None:
        asked = EndpointRecognizer("m", api_key=KEY)
        assert KEY not in repr(asked) + str(vars(asked)) + repr(find_address(api_key=KEY))
        with pytest.raises(ValueError, match="printable ASCII") as caught:
            find_address(api_key="sk-secret\n-split")
        assert "secret" not in str(caught.value)

    def test_openai_is_told_the_limit_by_its_newer_name(self) -> None:
        body = EndpointRecognizer("m", api_key=KEY).request_body(grey_clip(0))
        assert "max_completion_tokens" in body
        assert "max_tokens" not in body


def test_the_client_library_is_an_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openai", None)
    with pytest.raises(MissingExtraError, match=r"affectsim-data\[vlm\]"):
        recognizer_of("m")


def test_no_module_loads_it_on_import() -> None:
    folder = Path(endpoint_package.__file__).parent
    modules = sorted(folder.glob("*.py"))
    assert len(modules) > 8
    for path in modules:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        names += [
            a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names
        ]
        assert not {str(name).split(".")[0] for name in names} & {"openai", "httpx", "httpx2"}, path


def test_usage_is_told_in_lines(endpoint: Endpoint) -> None:
    with recognizer(endpoint) as asked:
        asked.recognize([grey_clip(0), grey_clip(1)])
    usage = asked.usage
    assert dataclasses.asdict(usage) == {
        **dict.fromkeys(["repeats", "failed", "refused", "truncated", "uncounted"], 0),
        "requests": 2,
        "answered": 2,
        "tokens_in": 200,
        "tokens_out": 4,
        "cost_usd": None,
    }
    assert usage.lines()[-1] == "tokens    200 in, 4 out"


class TestPredicting:
    """With `predict`: whatever stops a run, no clip that was answered is asked about again."""

    def test_a_run_that_was_stopped_goes_on(
        self, endpoint: Endpoint, small: Release, tmp_path: Path
    ) -> None:
        dataset, _ = undrawn(small, orbits=7)
        out = tmp_path / "answers.parquet"
        key_expires = [answer("B. fearful")] * 11 + [fail(401, "expired")] * 100
        endpoint.next_acts = key_expires
        with (
            recognizer(endpoint, concurrency=2) as asked,
            pytest.raises(EndpointStoppedError, match=r"HTTP 401: expired"),
        ):
            predict(asked, dataset, out, progress=False)
        answered = [json.dumps(seen.body) for seen in endpoint.seen[:11]]
        assert asked.usage.answered == 11
        endpoint.next_acts = []
        endpoint.seen.clear()
        with recognizer(endpoint, concurrency=2) as asked:
            run = predict(asked, dataset, out, progress=False)
        assert (run.num_clips, run.num_new, run.num_failed) == (20, 9, 0)
        later = [json.dumps(seen.body) for seen in endpoint.seen]
        assert len(later) == 9
        assert len({*answered, *later}) == 20
        rows = read_predictions([out]).table.to_pylist()
        texts = sorted(row["raw_text"] for row in rows)
        assert texts == ["B. fearful"] * 11 + ["happy"] * 9
        assert {row["model"] for row in rows} == {asked.name}

    def test_clips_without_an_answer_are_asked_about_again_and_no_others(
        self, endpoint: Endpoint, small: Release, tmp_path: Path
    ) -> None:
        dataset, _ = undrawn(small, orbits=2)
        out = tmp_path / "answers.parquet"
        endpoint.next_acts = [fail(400, "no"), answer(), fail(413, "too large")]
        for new, failed in ((8, 2), (2, 0), (0, 0)):
            endpoint.seen.clear()
            with recognizer(endpoint, concurrency=1) as asked:
                run = predict(asked, dataset, out, progress=False)
            assert (run.num_new, run.num_failed) == (new, failed)
            assert len(endpoint.seen) == new + failed
        assert len(read_predictions([out]).table) == 10
