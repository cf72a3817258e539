"""The one question vision-language models are asked about a clip, and how it is told apart."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from affectsim_data.evaluation.answers import parse_answer
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.recognizers.protocol import Reply

__all__ = ["PROMPT_VERSION", "answer", "option_order", "prompt_tag", "question"]

PROMPT_VERSION = 1
"""Moves with every change of a word below, and stands in the name of a model that was asked so."""

_LETTERS = "ABCDE"
_ONE = "This picture is a frame of a video."
_MANY = "These {count} pictures are frames of one video, in order of time."
_QUESTION = """\
{frames} \
It was taken in a home; the person may be small, hidden in part or seen from behind.
Which emotion does the person express? Judge by posture and movement. \
If there are two people, judge the one nearer to the middle of the pictures.
{options}
Answer with one letter or one word of this list, and nothing else."""


def question(options: Sequence[Emotion] = EMOTIONS, *, num_frames: int) -> str:
    """What a model is asked, after the pictures.

    Args:
        options: The five emotions, in the order of their letters A to E.
        num_frames: How many pictures there are.

    Raises:
        ValueError: Other options, or no picture.

    Examples:
        >>> print(question(num_frames=8))
        These 8 pictures are frames of one video, in order of time. \
It was taken in a home; the person may be small, hidden in part or seen from behind.
        Which emotion does the person express? Judge by posture and movement. \
If there are two people, judge the one nearer to the middle of the pictures.
        A. angry
        B. fearful
        C. happy
        D. neutral
        E. sad
        Answer with one letter or one word of this list, and nothing else.
    """
    _check(options)
    if num_frames < 1:
        raise ValueError(f"a question is about one picture or more, got num_frames={num_frames}")
    lettered = [f"{letter}. {name}" for letter, name in zip(_LETTERS, options, strict=True)]
    frames = _ONE if num_frames == 1 else _MANY.format(count=num_frames)
    text = _QUESTION.format(frames=frames, options="\n".join(lettered))
    return text.replace("of the pictures", "of the picture") if num_frames == 1 else text


def option_order(seed: int | None = None) -> tuple[Emotion, ...]:
    """The five emotions in the order their letters are given; the usual one without a seed.

    Models prefer some letters. Runs over several seeds show how much that moves a result.

    Examples:
        >>> option_order(1)
        ('angry', 'sad', 'neutral', 'happy', 'fearful')
    """
    if seed is None:
        return EMOTIONS
    # By hash, because what NumPy makes of a seed may change.
    return tuple(
        sorted(EMOTIONS, key=lambda name: hashlib.sha256(f"{seed} {name}".encode()).digest())
    )


def prompt_tag(options: Sequence[Emotion] = EMOTIONS) -> str:
    """What tells apart models that were asked differently; part of their names.

    Examples:
        >>> prompt_tag(), prompt_tag(("sad", "happy", "angry", "fearful", "neutral"))
        ('prompt 1', 'prompt 1, sad-happy-angry-fearful-neutral')
    """
    _check(options)
    order = "" if tuple(options) == EMOTIONS else f", {'-'.join(options)}"
    return f"prompt {PROMPT_VERSION}{order}"


def answer(
    text: str | None, options: Sequence[Emotion] = EMOTIONS, *, latency_ms: float | None = None
) -> Reply:
    """The reply a model's text is, with the label where letters are not in the usual order.

    A table of predictions does not say which letter meant what, so whoever asked in another order
    reads the answer, too.
    """
    label = None
    if tuple(options) != EMOTIONS:
        label = parse_answer(text, options=options).label
    return Reply(raw_text=text or "", label=label, latency_ms=latency_ms)


def _check(options: Sequence[str]) -> None:
    if sorted(options) != sorted(EMOTIONS):
        raise ValueError(
            f"options must be {', '.join(EMOTIONS)}, each once, got {', '.join(options)}"
        )
