"""A tiny model with random weights goes the whole way that a real one goes, offline."""

from __future__ import annotations

import builtins
import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import torch

from affectsim_data.errors import MissingExtraError
from affectsim_data.loaders import Sample
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.recognizers.local_model import TransformersRecognizer
from affectsim_data.recognizers.opening import open_recognizer
from affectsim_data.recognizers.prompts import option_order, question

TEMPLATE = (
    "{% for message in messages %}USER: {% for part in message['content'] %}"
    "{% if part['type'] == 'image' %}<image>{% else %}{{ part['text'] }}{% endif %}"
    "{% endfor %}{% endfor %}{% if add_generation_prompt %} ASSISTANT:{% endif %}"
)
IMAGE_SIZE, PATCH = 16, 8


def library(name: str) -> Any:
    """Imported when first needed, as it takes seconds."""
    return importlib.import_module(name)


def write_tokenizer(folder: Path) -> Any:
    """One token per byte, and the five emotions and `<image>` as words."""
    tokenizers, transformers = library("tokenizers"), library("transformers")
    alphabet = sorted(tokenizers.pre_tokenizers.ByteLevel.alphabet())
    vocabulary = {letter: number for number, letter in enumerate(alphabet)}
    inner = tokenizers.Tokenizer(tokenizers.models.BPE(vocabulary, []))
    inner.pre_tokenizer = tokenizers.pre_tokenizers.ByteLevel(add_prefix_space=False)
    inner.decoder = tokenizers.decoders.ByteLevel()
    tokenizer = transformers.PreTrainedTokenizerFast(
        tokenizer_object=inner,
        eos_token="</s>",
        additional_special_tokens=["<image>"],
    )
    tokenizer.save_pretrained(folder)
    return tokenizer


def write_model(folder: Path, *, template: str | None = TEMPLATE) -> None:
    """A LLaVA of some 30,000 random weights."""
    transformers, tokenizer = library("transformers"), write_tokenizer(folder)
    pictures = transformers.CLIPImageProcessorPil(
        size={"shortest_edge": IMAGE_SIZE}, crop_size={"height": IMAGE_SIZE, "width": IMAGE_SIZE}
    )
    transformers.LlavaProcessor(
        pictures,
        tokenizer,
        patch_size=PATCH,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
        chat_template=template,
    ).save_pretrained(folder)
    sizes = {"hidden_size": 16, "intermediate_size": 16, "num_hidden_layers": 2}
    heads = {"num_attention_heads": 2}
    config = transformers.LlavaConfig(
        vision_config=transformers.CLIPVisionConfig(
            **sizes, **heads, image_size=IMAGE_SIZE, patch_size=PATCH, projection_dim=16
        ),
        text_config=transformers.LlamaConfig(
            **sizes, **heads, vocab_size=len(tokenizer), num_key_value_heads=2
        ),
        image_token_index=tokenizer.convert_tokens_to_ids("<image>"),
        vision_feature_layer=-1,
    )
    torch.manual_seed(0)
    model = transformers.LlavaForConditionalGeneration(config)
    for weights in model.parameters():
        torch.nn.init.normal_(weights)  # large, so that answers hang on what is seen
    model.generation_config.do_sample = True  # which a recognizer must not heed
    model.generation_config.temperature = 5.0
    model.save_pretrained(folder)


@pytest.fixture(scope="module")
def model_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the tiny model; not to be changed by a test."""
    folder = tmp_path_factory.mktemp("models") / "tiny-llava"
    write_model(folder)
    return folder


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """So small a model is slower on several, and much slower where others work, too."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def recognizer(model_path: Path) -> TransformersRecognizer:
    """The tiny model, loaded."""
    return TransformersRecognizer(str(model_path), max_new_tokens=8, dtype="float32")


def clip(seed: int, num_frames: int = 3) -> Sample:
    """Noise to look at."""
    generator = torch.Generator().manual_seed(seed)
    video = torch.randint(0, 256, (num_frames, 3, 24, 24), dtype=torch.uint8, generator=generator)
    return {"video": video}  # type: ignore[typeddict-item]  # all a recognizer looks at


def asked(recognizer: TransformersRecognizer, *samples: Sample) -> dict[str, torch.Tensor]:
    """What the model is given for clips."""
    given: dict[str, torch.Tensor] = {}
    generate = recognizer._model.generate

    def listening(**inputs: Any) -> Any:
        given.update({name: v for name, v in inputs.items() if isinstance(v, torch.Tensor)})
        return generate(**inputs)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recognizer._model, "generate", listening)
        recognizer.recognize(samples)
    return given


def test_the_model_gets_every_frame_in_order_and_then_the_question(
    recognizer: TransformersRecognizer,
) -> None:
    sample = clip(0)
    given = asked(recognizer, sample)
    assert given["pixel_values"].shape == (3, 3, IMAGE_SIZE, IMAGE_SIZE)
    alone = [asked(recognizer, {**sample, "video": sample["video"][[one]]}) for one in range(3)]
    for number, one in enumerate(alone):
        assert torch.equal(given["pixel_values"][number], one["pixel_values"][0])
    tokenizer = recognizer._processor.tokenizer
    text = tokenizer.decode(given["input_ids"][0])
    patches = (IMAGE_SIZE // PATCH) ** 2
    expected = f"USER: {'<image>' * 3 * patches}{question(num_frames=3)} ASSISTANT:"
    assert text == expected


def test_an_answer_depends_on_each_frame_and_on_nothing_else(
    recognizer: TransformersRecognizer,
) -> None:
    def scores(sample: Sample) -> torch.Tensor:
        inputs = asked(recognizer, sample)
        with torch.inference_mode():
            logits: torch.Tensor = recognizer._model(**inputs).logits[0, -1]
        return logits

    sample = clip(1)
    first = scores(sample)
    torch.manual_seed(123)
    assert torch.equal(scores(sample), first)
    for number in range(3):
        video = sample["video"].clone()
        video[number] = 255 - video[number]
        assert not torch.allclose(scores({**sample, "video": video}), first)


def test_replies_are_text_the_same_every_time_and_in_order(
    recognizer: TransformersRecognizer,
) -> None:
    samples = [clip(seed) for seed in range(3)]
    replies = recognizer.recognize(samples)
    torch.manual_seed(99)  # sampling, which the model's own settings ask for, would notice
    assert recognizer.recognize(samples) == replies
    assert len({reply.raw_text for reply in replies}) > 1
    for sample, reply in zip(samples, replies, strict=True):
        assert reply.label is None
        assert reply.raw_text is not None
        # In a batch questions are padded in front; so many random weights round alike.
        assert recognizer.recognize([sample]) == [reply]


def test_clips_of_unequal_length_can_share_a_batch(recognizer: TransformersRecognizer) -> None:
    short, long = clip(4, num_frames=1), clip(5, num_frames=4)
    together = recognizer.recognize([short, long])
    assert together == [*recognizer.recognize([short]), *recognizer.recognize([long])]


def test_the_name_says_model_prompt_and_settings(
    recognizer: TransformersRecognizer, model_path: Path
) -> None:
    assert recognizer.name == "transformers:tiny-llava (prompt 1, float32, 8 tokens)"
    plain = open_recognizer(f"transformers:{model_path}", option_seed=1)
    order = "-".join(option_order(1))
    assert plain.name == f"transformers:tiny-llava (prompt 1, {order})"
    assert plain.batch_size == 1


def test_letters_in_another_order_are_read_by_that_order(
    model_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options: tuple[Emotion, ...] = ("sad", "neutral", "happy", "fearful", "angry")
    recognizer = TransformersRecognizer(str(model_path), options=options, max_new_tokens=1)
    monkeypatch.setattr(recognizer._processor, "batch_decode", lambda *_, **__: ["A"])
    (reply,) = recognizer.recognize([clip(0)])
    assert (reply.raw_text, reply.label) == ("A", "sad")
    assert EMOTIONS[0] == "angry"


def test_a_model_without_chat_template_is_refused(model_path: Path, tmp_path: Path) -> None:
    write_model(tmp_path, template=None)
    with pytest.raises(ValueError, match=r"has no chat template.*Instruct"):
        TransformersRecognizer(str(tmp_path))


def test_a_model_of_text_is_refused(tmp_path: Path) -> None:
    transformers, tokenizer = library("transformers"), write_tokenizer(tmp_path)
    config = transformers.LlamaConfig(
        hidden_size=8,
        intermediate_size=8,
        num_hidden_layers=1,
        num_attention_heads=1,
        vocab_size=len(tokenizer),
    )
    transformers.LlamaForCausalLM(config).save_pretrained(tmp_path)
    with pytest.raises(ValueError, match="takes no pictures beside text"):
        TransformersRecognizer(str(tmp_path))


def test_weights_that_are_no_safetensors_are_not_read(tmp_path: Path) -> None:
    write_model(tmp_path)
    (tmp_path / "model.safetensors").rename(tmp_path / "pytorch_model.bin")
    with pytest.raises(OSError, match="safetensors"):
        TransformersRecognizer(str(tmp_path))


def test_code_that_comes_with_a_model_is_not_run(tmp_path: Path) -> None:
    write_model(tmp_path)
    (tmp_path / "own.py").write_text("raise SystemExit('ran')\nclass Own: ...\n")
    config = json.loads((tmp_path / "config.json").read_text())
    config |= {
        "model_type": "own",
        "auto_map": {"AutoConfig": "own.Own", "AutoModelForImageTextToText": "own.Own"},
    }
    (tmp_path / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"trust_remote_code|custom code|own"):
        TransformersRecognizer(str(tmp_path))


def test_without_transformers_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def refusing(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == "transformers":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", refusing)
    monkeypatch.setitem(sys.modules, "transformers", None)
    with pytest.raises(MissingExtraError, match=r"affectsim-data\[vlm\]"):
        TransformersRecognizer("any/model")


@pytest.mark.parametrize("dtype", ["float33", "int8", "nn"])
def test_a_dtype_must_be_one_of_weights(model_path: Path, dtype: str) -> None:
    with pytest.raises(ValueError, match=f"dtype must be auto.*{dtype}"):
        TransformersRecognizer(str(model_path), dtype=dtype)
