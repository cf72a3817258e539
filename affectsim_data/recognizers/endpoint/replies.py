"""The body of a chat completion, checked: endpoints differ in what they leave out or add."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from affectsim_data.recognizers.endpoint.failures import (
    FILTERED,
    RequestFailure,
    failure_of_body,
    one_line,
)

__all__ = ["MAX_TEXT", "Answer", "read_answer"]

MAX_TEXT = 20_000
"""Characters of an answer that are kept."""


@dataclasses.dataclass(frozen=True)
class Answer:
    """What a model said to one request."""

    text: str
    """As it came, at most `MAX_TEXT` characters; empty if the model said nothing."""
    is_truncated: bool = False
    """Whether the limit of tokens or characters ended it."""
    is_refusal: bool = False
    """Whether the model or a content filter declined; `text` then says so."""
    tokens_in: int | None = None
    """Tokens of question and frames, if the endpoint told."""
    tokens_out: int | None = None
    """Tokens of thinking and answer, if the endpoint told."""


def read_answer(body: bytes, content_type: str = "") -> Answer:
    """The answer in the body of a response with status 200.

    Raises:
        RequestFailure: There is none in it.
    """
    completion = _completion(body, content_type)
    choice = _first_choice(completion)
    message = choice.get("message")
    if not isinstance(message, dict):
        raise RequestFailure(f"the choice has no message: {one_line(json.dumps(choice))}")
    finish = choice.get("finish_reason")
    if finish == "error":
        raise failure_of_body(choice.get("error") or "finish_reason is 'error'")
    tokens_in, tokens_out = _usage(completion.get("usage"))
    text, refusal = _text(message.get("content")), _text(message.get("refusal"))
    refused = bool(refusal.strip()) or finish == "content_filter"
    if refused and not text.strip():
        text = refusal if refusal.strip() else FILTERED
    if not text.strip() and not refused:
        _check_why_empty(message, finish, tokens_out)
    return Answer(
        _clean(text[:MAX_TEXT]),
        is_truncated=finish == "length" or len(text) > MAX_TEXT,
        is_refusal=refused,
        tokens_in=tokens_in,
        tokens_out=tokens_out,
    )


def _completion(body: bytes, content_type: str) -> dict[str, Any]:
    try:
        found = json.loads(body)
    except (ValueError, RecursionError):
        kind = one_line(content_type, most=60) or "of no declared type"
        begins = one_line(body[:400].decode("utf-8", "replace"), most=100)
        raise RequestFailure(
            f"the answer is not JSON ({kind}; is the base URL right? most end in /v1): {begins!r}"
        ) from None
    if not isinstance(found, dict):
        raise RequestFailure(f"the answer is no JSON object but {type(found).__name__}")
    if found.get("error"):
        raise failure_of_body(found["error"])
    return found


def _first_choice(completion: dict[str, Any]) -> dict[str, Any]:
    choices = completion.get("choices")
    if not isinstance(choices, list) or not choices or not isinstance(choices[0], dict):
        has = ", ".join(sorted(map(str, completion))) or "nothing"
        raise RequestFailure(f"the answer has no choices; it has {one_line(has)}")
    return choices[0]


def _text(content: Any) -> str:
    """Content as text: a string, or the text among parts that may also be thoughts."""
    if isinstance(content, str):
        return content
    parts = content if isinstance(content, list) else []
    texts = [part.get("text") for part in parts if _is_text(part)]
    return "".join(text for text in texts if isinstance(text, str))


def _is_text(part: Any) -> bool:
    return isinstance(part, dict) and part.get("type") == "text"


def _check_why_empty(message: dict[str, Any], finish: Any, tokens_out: int | None) -> None:
    """Raises RequestFailure if there is no answer because the tokens went into thoughts."""
    thought = any(_text(message.get(name)).strip() for name in ("reasoning_content", "reasoning"))
    if finish == "length" or thought:
        spent = "its tokens" if tokens_out is None else f"{tokens_out} tokens"
        raise RequestFailure(
            f"the model spent {spent} on thinking and gave no answer; allow more with max_tokens, "
            "or have it think less with extra_body",
            scope="clip",
        )


def _usage(usage: Any) -> tuple[int | None, int | None]:
    fields = usage if isinstance(usage, dict) else {}
    found = [fields.get(name) for name in ("prompt_tokens", "completion_tokens")]
    counts = [
        n if isinstance(n, int) and not isinstance(n, bool) and n >= 0 else None for n in found
    ]
    return counts[0], counts[1]


def _clean(text: str) -> str:
    """Without halves of surrogate pairs, which JSON can hold and no table can."""
    return text.encode("utf-8", "replace").decode("utf-8")
