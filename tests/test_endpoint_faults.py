"""An endpoint that misbehaves is asked again where that helps, and left alone where it does not."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import signal
import threading
import time
from collections.abc import Iterator
from email.utils import formatdate
from typing import Any

import numpy as np
import pytest
from endpoint_server import (
    Act,
    Endpoint,
    FakeClock,
    answer,
    answer_number,
    boast,
    completion,
    drip,
    echo_key,
    fail,
    flood,
    grey_clip,
    hang_up,
    send,
    serve_endpoint,
    stall,
)

from affectsim_data.evaluation.answers import parse_answer
from affectsim_data.recognizers import Reply
from affectsim_data.recognizers.endpoint import (
    EndpointRecognizer,
    EndpointStoppedError,
    Prices,
    RetryPolicy,
)
from affectsim_data.recognizers.endpoint.failures import FILTERED, RequestFailure, retry_after_s
from affectsim_data.recognizers.endpoint.replies import MAX_TEXT, read_answer

KEY = "sk-secret-of-the-tests"


@pytest.fixture
def endpoint() -> Iterator[Endpoint]:
    with serve_endpoint() as served:
        yield served


class HeldClock(FakeClock):
    """Time that stands still until it is released."""

    def __init__(self) -> None:
        super().__init__()
        self.released = threading.Event()

    async def sleep(self, duration_s: float) -> None:
        self.slept_s.append(duration_s)
        while not self.released.is_set():
            await asyncio.sleep(0.01)
        self._now_s += duration_s


def recognizer(endpoint: Endpoint, clock: FakeClock, **options: Any) -> EndpointRecognizer:
    defaults: dict[str, Any] = {"timeout_s": 5.0, "rng": np.random.default_rng(0)}
    return EndpointRecognizer(
        "the-model", base_url=endpoint.url, api_key=KEY, clock=clock, **{**defaults, **options}
    )


def ask(
    endpoint: Endpoint, *acts: Act, clips: int = 1, **options: Any
) -> tuple[list[Reply], FakeClock, EndpointRecognizer]:
    """Replies to some clips; the first requests are treated as told, the rest are answered."""
    endpoint.next_acts = list(acts)
    clock = FakeClock()
    with recognizer(endpoint, clock, **options) as asked:
        return asked.recognize([grey_clip(number) for number in range(clips)]), clock, asked


def body(**changed: Any) -> bytes:
    return json.dumps(completion(**changed)).encode()


TRANSIENT: dict[str, Act] = {
    "408": fail(408),
    "409": fail(409),
    "425": fail(425),
    "429": fail(429, "slow down"),
    "500": fail(500, "oops"),
    "502 that is a page": send(b"<html>Bad gateway</html>", "text/html"),
    "503": fail(503),
    "529": fail(529, "overloaded"),
    "hung up": hang_up(),
    "half an answer": send(body(), cut_to=40),
    "nothing of an answer": send(body(), cut_to=0),
    "no JSON": send(b"{'choices': ["),
    "empty": send(b""),
    "deep JSON": send(b"[" * 100_000),
    "a huge number": send(b'{"choices": ' + b"9" * 10_000 + b"}"),
    "a list": send(b"[]"),
    "no choices": send(b'{"id": "x"}'),
    "empty choices": send(b'{"choices": []}'),
    "choices of another kind": send(b'{"choices": [3]}'),
    "no message": send(b'{"choices": [{"finish_reason": "stop"}]}'),
    "an error with status 200": send(b'{"error": {"message": "upstream died", "code": 502}}'),
    "an error that is text": send(b'{"error": "try again"}'),
    "an answer that broke off": answer("hap", finish_reason="error"),
}


@pytest.mark.parametrize("act", TRANSIENT.values(), ids=TRANSIENT.keys())
def test_what_may_pass_is_asked_again(endpoint: Endpoint, act: Act) -> None:
    (reply,), clock, asked = ask(endpoint, act, act)
    assert reply.raw_text == "happy"
    assert len(endpoint.seen) == 3
    assert endpoint.seen[0].body == endpoint.seen[2].body
    assert len(clock.slept_s) == 2
    usage = asked.usage
    assert (usage.requests, usage.repeats, usage.answered, usage.failed) == (3, 2, 1, 0)


@pytest.mark.parametrize(
    ("act", "reason"),
    [
        (fail(429, "slow down"), "HTTP 429: slow down; asked 3 times"),
        (fail(503), "HTTP 503.*; asked 3 times"),
        (hang_up(), r"no connection: .*[Dd]isconnected.*; asked 3 times"),
        (send(body(), cut_to=40), "no connection: .*; asked 3 times"),
        (send(b"<html>\n<b>Hi</b>", "text/html"), r"not JSON \(text/html; .*<html> <b>Hi</b>"),
        (send(b'{"object": "list", "data": []}'), "has no choices; it has data, object"),
    ],
)
def test_giving_up_says_why_and_how_often(endpoint: Endpoint, act: Act, reason: str) -> None:
    endpoint.usual = act
    (reply,), clock, asked = ask(endpoint, clips=1, policy=RetryPolicy(max_attempts=3))
    assert reply.error is not None
    assert reply.raw_text is None
    assert len(endpoint.seen) == 3
    assert len(clock.slept_s) == 2
    assert asked.usage.failed == 1
    assert re.search(reason, reply.error), reply.error


@pytest.mark.parametrize("act", [stall(), drip()], ids=["stall", "slow drip"])
def test_an_answer_that_does_not_come_in_time_is_asked_for_again(
    endpoint: Endpoint, act: Act
) -> None:
    started_s = time.monotonic()
    (reply,), _, _ = ask(endpoint, act, timeout_s=0.3)
    assert reply.raw_text == "happy"
    assert 0.3 <= time.monotonic() - started_s < 3.0
    endpoint.usual = act
    (reply,), _, _ = ask(endpoint, timeout_s=0.1, policy=RetryPolicy(max_attempts=1))
    assert reply.error == "no answer within 0.1 s; asked once"


def test_one_that_stalls_does_not_stop_the_others(endpoint: Endpoint) -> None:
    endpoint.usual, endpoint.acts = answer_number(), {1: [stall()]}
    replies, _, _ = ask(endpoint, clips=6, timeout_s=0.4, concurrency=2)
    assert [reply.raw_text for reply in replies] == [f"clip {number}" for number in range(6)]


@pytest.mark.parametrize(
    "act",
    [flood(), boast(99_999_999)],
    ids=["without an end", "as it says itself"],
)
def test_an_answer_that_is_too_long_is_not_read(endpoint: Endpoint, act: Act) -> None:
    (reply,), _, _ = ask(endpoint, act)
    assert reply.error == "the answer is longer than 4 MB"
    assert len(endpoint.seen) == 1


def test_nor_is_an_error_that_is_too_long(endpoint: Endpoint) -> None:
    (reply,), _, _ = ask(endpoint, flood(status=500))
    assert reply.raw_text == "happy"
    assert len(endpoint.seen) == 2


def test_compressed_answers_are_not_asked_for(endpoint: Endpoint) -> None:
    ask(endpoint)
    assert endpoint.seen[0].headers["accept-encoding"] == "identity"


class TestWaiting:
    def test_waits_double_up_to_a_cap_and_have_full_jitter(self, endpoint: Endpoint) -> None:
        policy = RetryPolicy(max_attempts=8, base_s=1.0, cap_s=8.0)
        failure, rng = RequestFailure("no"), np.random.default_rng(0)
        waits = np.array(
            [
                [policy.wait_s(failure, attempts=n, elapsed_s=0.0, rng=rng) for n in range(1, 8)]
                for _ in range(2000)
            ]
        )
        longest = np.array([1.0, 2.0, 4.0, 8.0, 8.0, 8.0, 8.0])
        assert (waits.max(axis=0) <= longest).all()
        assert np.allclose(waits.mean(axis=0), longest / 2, rtol=0.05)
        assert np.allclose(waits.std(axis=0), longest / 12**0.5, rtol=0.05)

    @pytest.mark.parametrize(
        ("headers", "expected_s"),
        [
            ({"retry-after": "7"}, 7.0),
            ({"retry-after": "0.25"}, 0.25),
            ({"retry-after-ms": "1500", "retry-after": "7"}, 1.5),
            ({"retry-after-ms": "soon", "retry-after": "7"}, 7.0),
            ({"retry-after": formatdate(1000.0, usegmt=True)}, 100.0),
            ({"retry-after": formatdate(800.0, usegmt=True)}, 0.0),
            ({"retry-after": "-3"}, None),
            ({"retry-after": "inf"}, None),
            ({"retry-after": "nan"}, None),
            ({"retry-after": "tomorrow"}, None),
            ({"retry-after": "Thu, 99 Foo 2026 99:99:99 GMT"}, None),
            ({}, None),
        ],
    )
    def test_what_a_server_asks_for_is_understood(
        self, headers: dict[str, str], expected_s: float | None
    ) -> None:
        assert retry_after_s(headers, now_s=900.0) == expected_s

    @pytest.mark.parametrize("status", [429, 503])
    def test_and_done(self, endpoint: Endpoint, status: int) -> None:
        _, clock, _ = ask(endpoint, fail(status, headers={"Retry-After": "30"}))
        assert 30.0 <= sum(clock.slept_s) <= 32.0

    def test_a_date_is_understood_too(self, endpoint: Endpoint) -> None:
        date = formatdate(time.time() + 60.0, usegmt=True)
        _, clock, _ = ask(endpoint, fail(429, headers={"Retry-After": date}))
        assert 55.0 <= sum(clock.slept_s) <= 62.0

    def test_a_wait_longer_than_a_clip_may_take_ends_the_run(self, endpoint: Endpoint) -> None:
        endpoint.usual = fail(429, "quota of today", headers={"Retry-After": "7200"})
        with pytest.raises(EndpointStoppedError, match=r"wait 7,200 s.*run again then"):
            ask(endpoint, clips=8, concurrency=2)
        assert len(endpoint.seen) <= 2

    def test_after_a_429_all_wait(self, endpoint: Endpoint) -> None:
        """Clip 0 is told to wait; clip 1 is on its way; those after it wait with clip 0."""
        clock = HeldClock()
        seen_meanwhile = []

        def watch() -> None:
            deadline_s = time.monotonic() + 5.0
            while len(clock.slept_s) < 2 and time.monotonic() < deadline_s:
                time.sleep(0.01)
            seen_meanwhile.append(endpoint.asked())
            clock.released.set()

        def slow(handler: Any, seen: Any) -> None:
            while not clock.slept_s:
                time.sleep(0.01)
            answer()(handler, seen)

        endpoint.acts = {0: [fail(429, headers={"Retry-After": "40"})], 1: [slow]}
        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        with recognizer(endpoint, clock, concurrency=2) as asked:
            replies = asked.recognize([grey_clip(number) for number in range(5)])
        watcher.join(5.0)
        assert seen_meanwhile == [[0, 1]]
        assert [reply.raw_text for reply in replies] == ["happy"] * 5
        assert all(40.0 <= slept_s <= 42.0 for slept_s in clock.slept_s)
        assert len(clock.slept_s) == 2

    def test_no_wait_ends_after_the_deadline_of_a_clip(self, endpoint: Endpoint) -> None:
        endpoint.usual = fail(500)
        policy = RetryPolicy(max_attempts=1000, cap_s=10.0, deadline_s=60.0)
        (reply,), clock, _ = ask(endpoint, policy=policy)
        assert reply.error is not None
        assert " times in " in reply.error
        assert 40.0 <= sum(clock.slept_s) <= 60.0

    def test_answers_do_not_depend_on_the_waits(self, endpoint: Endpoint) -> None:
        found = []
        for seed in range(2):
            endpoint.usual = answer_number()
            endpoint.acts = {n: [fail(500)] * (n % 3) for n in range(6)}
            replies, _, _ = ask(endpoint, clips=6, rng=np.random.default_rng(seed))
            found.append([reply.raw_text for reply in replies])
        assert found[0] == found[1] == [f"clip {number}" for number in range(6)]

    @pytest.mark.parametrize(
        "wrong", [{"max_attempts": 0}, {"max_failures": 0}, {"base_s": -1.0}, {"deadline_s": 0.0}]
    )
    def test_a_policy_that_makes_no_sense_is_refused(self, wrong: dict[str, Any]) -> None:
        with pytest.raises(ValueError, match=next(iter(wrong))):
            RetryPolicy(**wrong)


class TestStopping:
    @pytest.mark.parametrize(
        ("act", "reason"),
        [
            (fail(401, "Incorrect API key"), "HTTP 401: Incorrect API key .the key is missing"),
            (fail(402), "no credit left"),
            (fail(403), "may not use the model"),
            (fail(404, "no model 'the-model'"), "no model 'the-model' .*most base URLs end in /v1"),
            (fail(405), "no address for chat completions"),
            (fail(429, "pay", code="insufficient_quota"), "no credit left"),
            (
                fail(
                    400, "Unsupported parameter", param="max_tokens", code="unsupported_parameter"
                ),
                "token_field='max_completion_tokens'",
            ),
            (
                fail(400, "Unsupported value: 0", param="temperature", code="unsupported_value"),
                "temperature=None leaves it out",
            ),
        ],
    )
    def test_what_no_clip_can_pass_ends_the_run_at_once(
        self, endpoint: Endpoint, act: Act, reason: str
    ) -> None:
        endpoint.usual = act
        with pytest.raises(EndpointStoppedError, match=reason) as caught:
            ask(endpoint, clips=20, concurrency=2)
        assert str(caught.value).startswith(f"the-model at {endpoint.url}: ")
        assert len(endpoint.seen) <= 2

    def test_redirects_are_not_followed(self, endpoint: Endpoint) -> None:
        with serve_endpoint() as other:
            elsewhere = f"{other.url}/chat/completions?token=x"
            endpoint.usual = fail(307, headers={"Location": elsewhere})
            with pytest.raises(EndpointStoppedError, match=r"HTTP 307.*not followed") as caught:
                ask(endpoint)
            assert not other.seen
        assert "token" not in str(caught.value)

    def test_connection_refused_is_tried_again_and_then_ends_the_run(self) -> None:
        with serve_endpoint() as gone:
            url = gone.url
        clock = FakeClock()
        policy = RetryPolicy(max_attempts=3, max_failures=4)
        asked = EndpointRecognizer("m", base_url=url, clock=clock, policy=policy)
        with asked, pytest.raises(EndpointStoppedError, match=r"4 clips in a row.*[Cc]onnect"):
            asked.recognize([grey_clip(0)] * 10)
        assert asked.usage.failed == 10
        assert 12 <= asked.usage.requests <= 12 + 8 * 2

    def test_failures_in_a_row_end_the_run_and_answers_before_are_kept(
        self, endpoint: Endpoint
    ) -> None:
        endpoint.acts = {0: [answer("sad")]}
        endpoint.usual = fail(400, "no images here")
        clock = FakeClock()
        with recognizer(
            endpoint, clock, concurrency=1, policy=RetryPolicy(max_failures=3)
        ) as asked:
            replies = asked.recognize([grey_clip(number) for number in range(10)])
            assert replies[0].raw_text == "sad"
            assert [reply.error for reply in replies[1:4]] == ["HTTP 400: no images here"] * 3
            for reply in replies[4:]:
                assert reply.error is not None
                assert reply.error.startswith("not asked: 3 clips in a row got no answer")
            with pytest.raises(EndpointStoppedError, match="no images here"):
                asked.recognize([grey_clip(0)])
        assert endpoint.asked() == [0, 1, 2, 3]

    def test_an_answer_in_between_begins_the_count_anew(self, endpoint: Endpoint) -> None:
        endpoint.acts = {number: [fail(400)] for number in (0, 1, 3, 4)}
        replies, _, _ = ask(endpoint, clips=6, concurrency=1, policy=RetryPolicy(max_failures=3))
        assert [reply.error is None for reply in replies] == [False, False, True] * 2

    def test_those_who_wait_are_woken_when_the_run_ends(self, endpoint: Endpoint) -> None:
        endpoint.acts = {0: [fail(500)], 1: [answer("x", after_s=0.1)], 2: [fail(401)]}
        policy = RetryPolicy(base_s=600.0, cap_s=600.0)
        asked = EndpointRecognizer(
            "m", base_url=endpoint.url, concurrency=2, policy=policy, rng=np.random.default_rng(0)
        )
        started_s = time.monotonic()
        with asked:
            replies = asked.recognize([grey_clip(number) for number in range(3)])
        assert time.monotonic() - started_s < 5.0
        assert [reply.raw_text for reply in replies] == [None, "x", None]

    @pytest.mark.parametrize("status", [400, 413, 422])
    def test_what_concerns_one_clip_is_not_asked_again(
        self, endpoint: Endpoint, status: int
    ) -> None:
        endpoint.acts = {1: [fail(status, "too big")]}
        replies, clock, _ = ask(endpoint, clips=3)
        assert [reply.raw_text for reply in replies] == ["happy", None, "happy"]
        assert replies[1].error is not None
        assert replies[1].error.startswith(f"HTTP {status}: too big")
        assert not clock.slept_s


class TestAnswers:
    def test_a_refusal_is_an_answer(self, endpoint: Endpoint) -> None:
        message = {"role": "assistant", "content": None, "refusal": "I can't judge people."}
        replies, _, asked = ask(
            endpoint,
            answer(message=message),
            answer(None, finish_reason="content_filter"),
            fail(400, "Sad content filtered.", code="content_filter"),
            clips=3,
            concurrency=1,
        )
        texts = [reply.raw_text for reply in replies]
        assert texts == ["I can't judge people.", FILTERED, FILTERED]
        assert {parse_answer(text).outcome for text in texts} == {"refusal"}
        assert (asked.usage.refused, asked.usage.answered) == (3, 3)

    @pytest.mark.parametrize("text", ["", "  \n", None])
    def test_nothing_is_an_answer(self, endpoint: Endpoint, text: str | None) -> None:
        (reply,), _, _ = ask(endpoint, answer(text))
        assert reply.raw_text == (text or "")
        assert reply.error is None

    def test_text_is_kept_as_it_came(self, endpoint: Endpoint) -> None:
        text = "<think>\n<b>hm</b> ../../x \U0001f600</think>\tB. sad\x00"
        (reply,), _, _ = ask(endpoint, answer(text))
        assert reply.raw_text == text

    def test_half_a_surrogate_pair_becomes_what_a_table_can_hold(self, endpoint: Endpoint) -> None:
        (reply,), _, _ = ask(endpoint, answer("sad \ud800"))
        assert reply.raw_text == "sad ?"

    def test_a_cut_answer_is_kept_and_counted(self, endpoint: Endpoint) -> None:
        replies, _, asked = ask(
            endpoint,
            answer("I think the per", finish_reason="length"),
            answer("x" * (MAX_TEXT + 5)),
            clips=2,
            concurrency=1,
        )
        assert [len(reply.raw_text or "") for reply in replies] == [15, MAX_TEXT]
        assert asked.usage.truncated == 2

    @pytest.mark.parametrize("field", ["reasoning_content", "reasoning"])
    def test_thoughts_without_an_answer_are_an_error_with_the_way_out(
        self, endpoint: Endpoint, field: str
    ) -> None:
        message = {"role": "assistant", "content": "", field: "Let me look at"}
        usage = {"prompt_tokens": 10, "completion_tokens": 256}
        (reply,), _, _ = ask(endpoint, answer(message=message, usage=usage))
        assert reply.error is not None
        assert reply.error.startswith("the model spent 256 tokens on thinking and gave no answer")
        assert len(endpoint.seen) == 1

    def test_thoughts_beside_an_answer_are_left_out(self) -> None:
        content = [
            {"type": "thinking", "thinking": "hm"},
            {"type": "text", "text": "sa"},
            {"type": "text", "text": "d"},
            {"type": "text"},
            7,
        ]
        message = {"content": content, "reasoning_content": "hm"}
        assert read_answer(json.dumps(completion(message=message)).encode()).text == "sad"

    @pytest.mark.parametrize(
        "usage", [None, [], {}, {"prompt_tokens": "9"}, {"prompt_tokens": -1}, {"x": True}]
    )
    def test_usage_that_is_none_is_counted_as_unknown(self, usage: Any) -> None:
        found = read_answer(json.dumps(completion("sad", usage=usage)).encode())
        assert (found.text, found.tokens_in, found.tokens_out) == ("sad", None, None)

    def test_any_bytes_are_an_answer_or_a_failure(self) -> None:
        """Never another exception: pieces of a good answer, changed at random."""
        rng, good = np.random.default_rng(0), body(message={"content": ["x", {"type": "text"}]})
        outcomes = set()
        for _ in range(2000):
            piece = bytearray(good[: rng.integers(len(good) + 1)] if rng.random() < 0.2 else good)
            for place in rng.integers(max(len(piece), 1), size=2):
                piece[place : place + 1] = bytes([rng.integers(32, 127)])
            try:
                read_answer(bytes(piece))
                outcomes.add("answer")
            except RequestFailure as failure:
                outcomes.add(failure.scope)
        assert {"answer", "attempt"} <= outcomes


class TestTheKey:
    @pytest.mark.parametrize("status", [400, 401, 500])
    def test_is_in_no_error_and_no_log(
        self, endpoint: Endpoint, status: int, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.DEBUG)
        endpoint.usual = echo_key(status)
        told = ""
        try:
            replies, _, asked = ask(endpoint, policy=RetryPolicy(max_attempts=2))
            told = f"{replies} {asked.usage}"
        except EndpointStoppedError as error:
            told = f"{error!r} {error.__cause__!r}"
        assert "bad key: Bearer [key]" in told
        assert KEY not in told
        assert KEY not in caplog.text

    def test_is_in_no_text_kept(self, endpoint: Endpoint) -> None:
        (reply,), _, _ = ask(endpoint, answer(f"your key is {KEY}"))
        assert reply.raw_text == "your key is [key]"


class TestMoney:
    PRICES = Prices(tokens_in=10_000.0, tokens_out=0.0)
    """An answer costs one dollar: it has 100 tokens in."""

    def test_what_was_used_is_summed(self, endpoint: Endpoint) -> None:
        _, _, asked = ask(endpoint, fail(500), clips=3, prices=Prices(2.0, 8.0))
        assert asked.usage.cost_usd == pytest.approx(3 * (100 * 2.0 + 2 * 8.0) / 1e6)
        assert asked.usage.requests == 4

    def test_the_run_ends_before_the_limit_is_passed(self, endpoint: Endpoint) -> None:
        endpoint.usual = answer()
        clock = FakeClock()
        with recognizer(
            endpoint, clock, prices=self.PRICES, max_cost_usd=6.5, concurrency=1
        ) as asked:
            replies = asked.recognize([grey_clip(number) for number in range(10)])
            answered = [reply.raw_text for reply in replies if reply.error is None]
            assert len(answered) == len(endpoint.seen) == 6
            assert asked.usage.cost_usd == pytest.approx(6.0)
            assert replies[9].error is not None
            assert "max_cost_usd" in replies[9].error
            with pytest.raises(EndpointStoppedError, match=r"6\.00 of 6\.50 USD"):
                asked.recognize([grey_clip(0)])
        assert len(endpoint.seen) == 6

    def test_requests_on_their_way_count(self, endpoint: Endpoint) -> None:
        endpoint.usual = answer(after_s=0.02)
        _, _, asked = ask(endpoint, clips=30, prices=self.PRICES, max_cost_usd=16.0, concurrency=8)
        assert asked.usage.cost_usd is not None
        assert 8.0 <= asked.usage.cost_usd <= 16.0

    def test_answers_without_usage_cost_what_was_estimated(self, endpoint: Endpoint) -> None:
        endpoint.usual = answer(usage=None)
        _, _, asked = ask(endpoint, clips=2, prices=self.PRICES)
        assert asked.usage.uncounted == 2
        assert asked.usage.cost_usd is not None
        assert asked.usage.cost_usd > 5.0


def test_an_interrupt_breaks_requests_off(endpoint: Endpoint) -> None:
    """Ctrl-C while requests stall ends the wait at once, and nothing goes on behind it."""
    endpoint.usual = stall()
    main = threading.main_thread().ident
    assert main == threading.get_ident()

    def interrupt() -> None:
        while not endpoint.seen:
            time.sleep(0.01)
        signal.pthread_kill(main, signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    thread = threading.Thread(target=interrupt, daemon=True)
    started_s = time.monotonic()
    try:
        thread.start()
        asked = recognizer(endpoint, FakeClock(), timeout_s=60.0)
        with asked, pytest.raises(KeyboardInterrupt):
            asked.recognize([grey_clip(0)])
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - started_s < 5.0
    assert len(endpoint.seen) == 1
