"""What a run will take is said beforehand, by rules one can check by hand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from endpoint_server import Endpoint, FakeClock, answer, fail, grey_clip, serve_endpoint

from affectsim_data.loaders import Clip
from affectsim_data.recognizers.endpoint import (
    EndpointRecognizer,
    EndpointStoppedError,
    ImageRule,
    Prices,
    Probe,
    estimate_cost,
    image_tokens,
)

CLIP = Clip(num_frames=8, width=224, height=224)


@pytest.fixture
def endpoint() -> Iterator[Endpoint]:
    with serve_endpoint() as served:
        yield served


@pytest.mark.parametrize(
    ("rule", "size", "expected"),
    [
        ("tiles", (224, 224), 85 + 170),
        ("tiles", (512, 512), 85 + 170),
        ("tiles", (513, 512), 85 + 2 * 170),
        ("tiles", (1024, 1024), 85 + 4 * 170),  # 768 x 768
        ("tiles", (2048, 4096), 85 + 6 * 170),  # 1024 x 2048, then 768 x 1536
        ("patches_32", (224, 224), 7 * 7),
        ("patches_32", (225, 224), 8 * 7),
        ("patches_32", (4000, 4000), 1536),
        ("patches_28", (224, 224), 8 * 8 + 2),
        ("patches_28", (448, 448), 16 * 16 + 2),
        ("patches_28", (10, 10), 4 + 2),
        ("tiles_768", (384, 384), 258),
        ("tiles_768", (385, 384), 258),
        ("tiles_768", (1000, 700), 2 * 258),
        ("area", (750, 100), 100),
    ],
)
def test_tokens_of_a_picture(rule: ImageRule, size: tuple[int, int], expected: int) -> None:
    assert image_tokens(*size, rule) == expected


def test_an_estimate_adds_up() -> None:
    prices = Prices(tokens_in=2.0, tokens_out=8.0)
    found = estimate_cost(
        1000,
        CLIP,
        prices,
        concurrency=8,
        tokens_per_image=100,
        tokens_per_answer=5,
        latency_s=2.0,
        bytes_per_frame=9000.0,
    )
    text_tokens = found.tokens_in / 1000 - 800
    assert 100 < text_tokens < 200
    assert found.num_requests == 1000
    assert found.tokens_out == 5000
    assert found.cost_usd == pytest.approx((2.0 * found.tokens_in + 8.0 * 5000) / 1e6)
    assert found.duration_s == 125 * 2.0
    assert 8 * 12_000 * 1000 / 1e6 < found.megabytes_sent < 8 * 12_000 * 1000 / 1e6 * 1.03
    assert found.lines() == [
        f"requests  1,000, {found.megabytes_sent:,.0f} MB sent",
        f"tokens    {found.tokens_in:,} in, 5,000 out",
        f"cost      {found.cost_usd:.2f} USD",
        "time      4 min",
        "based on  100 tokens a frame as given, 2 s an answer as assumed",
    ]


def test_without_prices_the_cost_is_unknown_and_not_nothing() -> None:
    found = estimate_cost(10, CLIP)
    assert found.cost_usd is None
    assert "cost      unknown: give the prices" in found.lines()
    assert estimate_cost(0, CLIP, Prices(1.0, 1.0)).cost_usd == 0.0
    assert estimate_cost(10, CLIP, Prices(0.0, 0.0)).cost_usd == 0.0


def test_more_of_anything_costs_more() -> None:
    def cost(num_clips: int = 10, clip: Clip = CLIP, **options: Any) -> float:
        found = estimate_cost(num_clips, clip, Prices(1.0, 1.0), **options).cost_usd
        assert found is not None
        return found

    assert cost(num_clips=11) > cost()
    assert cost(clip=Clip(num_frames=16, width=224, height=224)) > cost()
    assert cost(clip=Clip(num_frames=8, width=640, height=640)) > cost()
    assert cost(tokens_per_answer=500) > cost()
    assert cost(image_rule="patches_28") < cost()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"num_clips": -1}, "num_clips"),
        ({"concurrency": 0}, "concurrency at least 1"),
        ({"latency_s": -1.0}, "latency_s"),
        ({"tokens_per_image": -5}, "tokens_per_image must be 0 or more, got -5"),
        ({"clip": Clip(num_frames="all", width=8, height=8)}, "give it a number"),
        ({"image_rule": "guess"}, "rule must be one of tiles, .* got 'guess'"),
    ],
)
def test_what_cannot_be_estimated_is_refused(wrong: dict[str, Any], message: str) -> None:
    given = {"num_clips": 1, "clip": CLIP, **wrong}
    with pytest.raises(ValueError, match=message):
        estimate_cost(**given)


@pytest.mark.parametrize("price", [-1.0, float("nan"), float("inf")])
def test_prices_are_numbers(price: float) -> None:
    with pytest.raises(ValueError, match="USD per million tokens"):
        Prices(1.0, price)


def test_estimating_sends_nothing_and_weighs_the_frames_at_hand(endpoint: Endpoint) -> None:
    asked = EndpointRecognizer("m", base_url=endpoint.url, prices=Prices(1.0, 1.0))
    sample = grey_clip(3, num_frames=4, side=64)
    found = asked.estimate(1000, sample)
    assert not endpoint.seen
    with asked:
        asked.recognize([sample])
    sent = int(endpoint.seen[0].headers["content-length"])
    # What the client library adds, in headers, is not known beforehand.
    assert found.megabytes_sent * 1e6 / 1000 == pytest.approx(sent + 700, rel=0.05)


def test_smaller_frames_are_estimated_as_such() -> None:
    def tokens(**options: Any) -> int:
        asked = EndpointRecognizer("m", base_url="http://localhost:1", **options)
        sample = grey_clip(3, num_frames=1, side=560)
        return asked.estimate(1, sample, image_rule="patches_28").tokens_in

    assert tokens() - tokens(max_side=280) == 20 * 20 - 10 * 10


def test_a_probe_replaces_what_was_assumed(endpoint: Endpoint) -> None:
    usage = {"prompt_tokens": 321, "completion_tokens": 7}
    endpoint.usual = answer(after_s=0.05, usage=usage)
    with EndpointRecognizer("m", base_url=endpoint.url) as asked:
        probe = asked.probe(grey_clip(0))
        found = asked.estimate(80, grey_clip(0), probe=probe)
    assert len(endpoint.seen) == 1
    assert (probe.tokens_in, probe.tokens_out) == (321, 7)
    assert probe.latency_s >= 0.05
    assert (found.tokens_in, found.tokens_out) == (80 * 321, 80 * 7)
    assert found.duration_s == pytest.approx(10 * probe.latency_s)
    assert found.basis.startswith("one request: 321 tokens in, 7 out, 0.")


def test_a_probe_of_an_endpoint_that_tells_no_usage() -> None:
    probe = Probe(latency_s=1.0, tokens_in=None, tokens_out=None)
    found, assumed = estimate_cost(10, CLIP, probe=probe), estimate_cost(10, CLIP)
    assert (found.tokens_in, found.tokens_out) == (assumed.tokens_in, assumed.tokens_out)


def test_a_probe_that_fails_says_where_and_why(endpoint: Endpoint) -> None:
    endpoint.usual = fail(503, "loading the model")
    clock = FakeClock()
    asked = EndpointRecognizer("m", base_url=endpoint.url, clock=clock)
    with asked, pytest.raises(EndpointStoppedError, match=r"m at http.*HTTP 503: loading"):
        asked.probe(grey_clip(0))
    assert len(endpoint.seen) == 1
