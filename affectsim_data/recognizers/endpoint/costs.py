"""What a run over an endpoint will take: requests, megabytes, tokens, money and time."""

from __future__ import annotations

import dataclasses
import math
from typing import Literal, get_args

from affectsim_data.loaders import Clip
from affectsim_data.motions import EMOTIONS
from affectsim_data.recognizers.prompts import question

__all__ = ["CostEstimate", "ImageRule", "Prices", "Probe", "estimate_cost", "image_tokens"]

ImageRule = Literal["tiles", "patches_28", "patches_32", "tiles_768", "area"]
"""How models count the tokens of a picture; see `image_tokens`."""
_JPEG_BYTES_PER_PIXEL = 0.25
"""At quality 90: frames of 224 pixels have 0.21 to 0.24, of 448 pixels 0.16 to 0.19."""
_CHARACTERS_PER_TOKEN = 3.5
_REQUEST_TOKENS, _REQUEST_BYTES = 16, 900
"""Of a request without question and frames: chat template, JSON and headers."""
_FRAME_BYTES = 70
"""Of a frame in JSON, beside its base64."""


@dataclasses.dataclass(frozen=True)
class Prices:
    """What an endpoint charges, USD per million tokens."""

    tokens_in: float
    """Question and frames."""
    tokens_out: float
    """Thinking and answer."""

    def __post_init__(self) -> None:
        for price in (self.tokens_in, self.tokens_out):
            if not (math.isfinite(price) and price >= 0):
                raise ValueError(f"a price must be USD per million tokens, 0 or more, got {price}")

    def cost(self, tokens_in: float, tokens_out: float) -> float:
        """USD for some tokens.

        Examples:
            >>> Prices(tokens_in=2.0, tokens_out=8.0).cost(1_000_000, 500_000)
            6.0
        """
        return (self.tokens_in * tokens_in + self.tokens_out * tokens_out) / 1e6


@dataclasses.dataclass(frozen=True)
class Probe:
    """What one request about one clip took."""

    latency_s: float
    """From sending to the whole answer, on an idle connection."""
    tokens_in: int | None
    """As the endpoint counted them."""
    tokens_out: int | None
    """As the endpoint counted them."""


@dataclasses.dataclass(frozen=True)
class CostEstimate:
    """What asking about some clips should take, if nothing has to be asked twice."""

    num_requests: int
    """One per clip."""
    megabytes_sent: float
    """Frames in base64, and what is around them."""
    tokens_in: int
    """Question and frames."""
    tokens_out: int
    """Thinking and answers."""
    cost_usd: float | None
    """`None` if prices are not known."""
    duration_s: float
    """With as many requests at a time as allowed, none of them refused."""
    basis: str
    """Where tokens and latency come from."""

    def lines(self) -> list[str]:
        """For people, a line each."""
        cost = "unknown: give the prices" if self.cost_usd is None else f"{self.cost_usd:,.2f} USD"
        return [
            f"requests  {self.num_requests:,}, {self.megabytes_sent:,.0f} MB sent",
            f"tokens    {self.tokens_in:,} in, {self.tokens_out:,} out",
            f"cost      {cost}",
            f"time      {_duration(self.duration_s)}",
            f"based on  {self.basis}",
        ]


def estimate_cost(
    num_clips: int,
    clip: Clip,
    prices: Prices | None = None,
    *,
    concurrency: int = 8,
    image_rule: ImageRule = "tiles",
    tokens_per_image: int | None = None,
    tokens_per_answer: int = 10,
    latency_s: float = 3.0,
    bytes_per_frame: float | None = None,
    probe: Probe | None = None,
) -> CostEstimate:
    """What asking about clips should take. Nothing is sent.

    Args:
        num_clips: How many.
        clip: Frames and their size.
        prices: What the endpoint charges; without it the cost is not known.
        concurrency: Requests at a time.
        image_rule: How the model counts the tokens of a frame; at 224 pixels `tiles` and
            `tiles_768` are the dearest, the others a quarter of that.
        tokens_per_image: Their number, where it is known; then the rule does not matter.
        tokens_per_answer: Tokens of thinking and answer.
        latency_s: Time to one answer.
        bytes_per_frame: Of a JPEG file; if not given, from the number of pixels.
        probe: What one request took; then its tokens and latency count, not these.

    Raises:
        ValueError: A number is negative, or the clip has no fixed number of frames.
    """
    if clip.num_frames == "all":
        raise ValueError(f"clip {clip.name!r} has all frames of a video; give it a number of them")
    if num_clips < 0 or concurrency < 1 or latency_s < 0 or tokens_per_answer < 0:
        raise ValueError(
            "num_clips, latency_s and tokens_per_answer must be 0 or more and concurrency at "
            f"least 1, got {num_clips}, {latency_s}, {tokens_per_answer} and {concurrency}"
        )
    if tokens_per_image is not None and tokens_per_image < 0:
        raise ValueError(f"tokens_per_image must be 0 or more, got {tokens_per_image}")
    asked = question(EMOTIONS, num_frames=clip.num_frames)
    per_image, basis = tokens_per_image, f"{tokens_per_image} tokens a frame as given"
    if per_image is None:
        per_image = image_tokens(clip.width, clip.height, image_rule)
        basis = f"{per_image} tokens a frame by the rule {image_rule!r}"
    text_tokens = math.ceil(len(asked) / _CHARACTERS_PER_TOKEN) + _REQUEST_TOKENS
    tokens_in, tokens_out = clip.num_frames * per_image + text_tokens, tokens_per_answer
    basis = f"{basis}, {latency_s:g} s an answer as assumed"
    if probe is not None:
        tokens_in = tokens_in if probe.tokens_in is None else probe.tokens_in
        tokens_out = tokens_out if probe.tokens_out is None else probe.tokens_out
        latency_s = probe.latency_s
        basis = f"one request: {tokens_in} tokens in, {tokens_out} out, {latency_s:.2g} s"
    if bytes_per_frame is None:
        bytes_per_frame = _JPEG_BYTES_PER_PIXEL * clip.width * clip.height
    cost_usd = None
    if prices is not None:
        cost_usd = prices.cost(num_clips * tokens_in, num_clips * tokens_out)
    frame_bytes = bytes_per_frame * 4 / 3 + _FRAME_BYTES
    request_bytes = clip.num_frames * frame_bytes + len(asked) + _REQUEST_BYTES
    return CostEstimate(
        num_requests=num_clips,
        megabytes_sent=num_clips * request_bytes / 1e6,
        tokens_in=num_clips * tokens_in,
        tokens_out=num_clips * tokens_out,
        cost_usd=cost_usd,
        duration_s=math.ceil(num_clips / concurrency) * latency_s,
        basis=basis,
    )


def image_tokens(width: int, height: int, rule: ImageRule) -> int:
    """Tokens a picture counts as, by the published rules of some families of models.

    - `tiles` (GPT-4o and kin, detail high): made to fit 2048 x 2048, then a shorter side of at most
      768; 85 tokens, and 170 for each tile of 512 pixels begun. (Some readings of that rule make
      small pictures larger first; a frame of 224 pixels then has 765 tokens, not 255.)
    - `patches_32` (newer GPT, Qwen3-VL): one for each 32 x 32 pixels begun, at most 1,536. Some
      small GPT models are charged a multiple of that.
    - `patches_28` (Qwen2-VL, Qwen2.5-VL): one for each 28 x 28 pixels, rounded, at least 4; and 2
      around them.
    - `tiles_768` (Gemini): 258 up to 384 pixels, else 258 for each tile of 768 begun.
    - `area` (Claude): one for 750 pixels.

    Examples:
        >>> [image_tokens(224, 224, rule) for rule in ("tiles", "patches_28", "tiles_768")]
        [255, 66, 258]
        >>> image_tokens(1024, 1024, "tiles")
        765
    """
    if width < 1 or height < 1:
        raise ValueError(f"a picture must have pixels, got {width} x {height}")
    if rule == "tiles":
        scale = min(1.0, 2048 / max(width, height))
        scale = min(scale, 768 / min(width, height))
        return 85 + 170 * _tiles(round(width * scale), round(height * scale), 512)
    if rule == "patches_32":
        return min(1536, _tiles(width, height, 32))
    if rule == "patches_28":
        return max(4, max(1, round(width / 28)) * max(1, round(height / 28))) + 2
    if rule == "tiles_768":
        return 258 if max(width, height) <= 384 else 258 * _tiles(width, height, 768)
    if rule == "area":
        return math.ceil(width * height / 750)
    raise ValueError(f"rule must be one of {', '.join(get_args(ImageRule))}, got {rule!r}")


def _tiles(width: int, height: int, side: int) -> int:
    return math.ceil(width / side) * math.ceil(height / side)


def _duration(duration_s: float) -> str:
    if duration_s < 90:
        return f"{duration_s:.0f} s"
    minutes = round(duration_s / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60:02d} min"
