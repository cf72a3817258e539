"""Vision-language models run here, by Hugging Face transformers: any of image-text-to-text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from PIL import Image

from affectsim_data.errors import require_extra
from affectsim_data.loaders import Sample
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.recognizers.frames import frame_pictures
from affectsim_data.recognizers.prompts import answer, prompt_tag, question
from affectsim_data.recognizers.protocol import Reply

__all__ = ["TransformersRecognizer"]

_MAX_NEW_TOKENS = 64
"""Enough for a sentence around the answer."""
_GREEDY = {"do_sample": False, "num_beams": 1, "temperature": None, "top_p": None, "top_k": None}


class TransformersRecognizer:
    """Asks a model the project's question about the frames of a clip, in one turn of a chat.

    Decoding is greedy. No code that comes with a model is run, and no weights but safetensors are
    read. Needs the extra `vlm`.
    """

    def __init__(
        self,
        model: str,
        *,
        revision: str | None = None,
        device: str = "cpu",
        dtype: str = "auto",
        options: Sequence[Emotion] = EMOTIONS,
        max_new_tokens: int = _MAX_NEW_TOKENS,
        batch_size: int = 1,
    ) -> None:
        """Loads the model, from the Hub if it is no folder.

        Args:
            model: A name on the Hub, or a folder.
            revision: Commit, tag or branch on the Hub.
            device: Where it runs: `cpu`, `cuda`, `cuda:1`, ...
            dtype: `auto` for that of the weights, or `float32`, `bfloat16`, ...
            options: The emotions in the order of their letters.
            max_new_tokens: Longest answer.
            batch_size: Clips at once. Sums are rounded otherwise in a batch, so only with 1 does
                an answer never depend on what else was asked.

        Raises:
            MissingExtraError: transformers is not installed.
            OSError: There is no such model, or none with safetensors.
            ValueError: It does not take pictures and text, or has no chat template.
        """
        transformers: Any = require_extra("transformers", extra="vlm")
        if max_new_tokens < 1 or batch_size < 1:
            raise ValueError(
                f"max_new_tokens and batch_size must be from 1 up, got {max_new_tokens} and "
                f"{batch_size}"
            )
        self.batch_size = batch_size
        self._options, self._max_new_tokens = tuple(options), max_new_tokens
        common = {"revision": revision, "trust_remote_code": False}
        self._processor = transformers.AutoProcessor.from_pretrained(model, **common)
        self._check_processor(model)
        self._model = self._load(transformers, model, _dtype(dtype), common).to(device).eval()
        self._model.generation_config.update(**_GREEDY)
        self.name = self._full_name(model, revision, dtype)

    def _check_processor(self, model: str) -> None:
        tokenizer = getattr(self._processor, "tokenizer", None)
        if tokenizer is None or getattr(self._processor, "image_processor", None) is None:
            raise ValueError(
                f"{model}: takes no pictures beside text; a recognizer needs a model of "
                "image-text-to-text"
            )
        if self._processor.chat_template is None:
            raise ValueError(
                f"{model}: has no chat template, so nothing says how to ask it; take the variant "
                "that follows instructions (Instruct, Chat, -it)"
            )
        tokenizer.padding_side = "left"  # answers begin where the questions end
        if tokenizer.pad_token is None:
            tokenizer.pad_token = tokenizer.eos_token

    @staticmethod
    def _load(
        transformers: Any, model: str, dtype: str | torch.dtype, common: dict[str, Any]
    ) -> Any:
        kind = transformers.AutoModelForImageTextToText
        try:
            return kind.from_pretrained(model, dtype=dtype, use_safetensors=True, **common)
        except ValueError as error:
            if "Unrecognized configuration class" not in str(error):
                raise
            raise ValueError(
                f"{model}: is no model of image-text-to-text for transformers "
                f"{transformers.__version__}"
            ) from error

    def _full_name(self, model: str, revision: str | None, dtype: str) -> str:
        """What tells its answers from those of any other: a commit, for a model of the Hub."""
        folder = Path(model)
        commit = getattr(self._model.config, "_commit_hash", None) or revision
        which = folder.resolve().name if folder.is_dir() else model
        told = [prompt_tag(self._options)]
        if dtype != "auto":
            told.append(dtype)
        if self._max_new_tokens != _MAX_NEW_TOKENS:
            told.append(f"{self._max_new_tokens} tokens")
        return f"transformers:{which}{f'@{commit[:12]}' if commit else ''} ({', '.join(told)})"

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """What the model says to each clip."""
        chats = [self._chat(frame_pictures(sample["video"])) for sample in samples]
        inputs = self._processor.apply_chat_template(
            chats,
            add_generation_prompt=True,
            tokenize=True,
            return_dict=True,
            return_tensors="pt",
            processor_kwargs={"padding": True},
        ).to(self._model.device, dtype=self._model.dtype)
        with torch.inference_mode():
            tokens = self._model.generate(**inputs, max_new_tokens=self._max_new_tokens)
        said = self._processor.batch_decode(
            tokens[:, inputs["input_ids"].shape[1] :], skip_special_tokens=True
        )
        return [answer(text.strip(), self._options) for text in said]

    def _chat(self, pictures: Sequence[Image.Image]) -> list[dict[str, Any]]:
        asked = question(self._options, num_frames=len(pictures))
        content: list[dict[str, Any]] = [{"type": "image", "image": one} for one in pictures]
        return [{"role": "user", "content": [*content, {"type": "text", "text": asked}]}]


def _dtype(name: str) -> str | torch.dtype:
    if name == "auto":
        return name
    found = getattr(torch, name, None)
    if not isinstance(found, torch.dtype) or not found.is_floating_point:
        raise ValueError(f"dtype must be auto, float32, bfloat16 or float16, got {name!r}")
    return found
