"""The small video network: its input, its file, its joints, its training."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from affectsim_data.loaders import AffectSimDataset, Sample
from affectsim_data.motions import EMOTIONS
from affectsim_data.recognizers import training
from affectsim_data.recognizers.network import (
    INPUT_SIZE,
    ClipNetwork,
    NetworkRecognizer,
    network_input,
)
from affectsim_data.recognizers.training import TrainingClips, load_clips, train_network
from affectsim_data.releases import Release
from affectsim_data.skeletons import JOINT_NAMES

pytestmark = pytest.mark.timeout(120)


def random_clips(count: int = 6, *, frames: int = 4, seed: int = 0) -> TrainingClips:
    """Noise with joints anywhere, and labels in turn."""
    generator = torch.Generator().manual_seed(seed)
    size = (count, frames, 3, INPUT_SIZE, INPUT_SIZE)
    return TrainingClips(
        video=torch.randint(0, 256, size, dtype=torch.uint8, generator=generator),
        joints=torch.rand((count, frames, len(JOINT_NAMES), 2), generator=generator),
        labels=torch.arange(count) % len(EMOTIONS),
    )


def dotted_clips(places: torch.Tensor, *, joint: int) -> TrainingClips:
    """A bright dot at each place `(count, 2)`, which is where the joint is; others are nowhere."""
    count = len(places)
    centres = (torch.arange(INPUT_SIZE) + 0.5) / INPUT_SIZE
    off_x = (centres[None, :] - places[:, :1])[:, None, :]
    off_y = (centres[None, :] - places[:, 1:])[:, :, None]
    spot = 250.0 * torch.exp(-(off_x**2 + off_y**2) / (2 * 0.03**2))
    grain = 5.0 * torch.rand(spot.shape, generator=torch.Generator().manual_seed(9))
    video = (spot + grain).clamp(max=255.0).to(torch.uint8)[:, None, None]
    video = video.expand(-1, 1, 3, -1, -1).contiguous()
    joints = torch.full((count, 1, len(JOINT_NAMES), 2), -5.0)
    joints[:, :, joint] = places[:, None]
    return TrainingClips(video, joints, torch.zeros(count, dtype=torch.int64))


def test_input_is_resized_by_area() -> None:
    video = torch.zeros(2, 3, 224, 224, dtype=torch.uint8)
    video[:, :, 0, 0] = 200  # one of four pixels of the first cell
    small = network_input(video)
    assert small.shape == (2, 3, INPUT_SIZE, INPUT_SIZE)
    assert small.dtype == torch.uint8
    assert small[0, 0, 0, 0] == 50
    assert small[..., 1:].eq(0).all()
    assert network_input(small) is small


def test_answers_do_not_depend_on_the_batch() -> None:
    torch.manual_seed(0)
    network = ClipNetwork().eval()
    video = random_clips(3).video
    with torch.inference_mode():
        together, heat = network(video), network.look_at(video)[1]
        alone = torch.cat([network(one[None]) for one in video])
    torch.testing.assert_close(together, alone, rtol=1e-4, atol=1e-5)
    assert together.shape == (3, 5)
    assert heat.shape == (3, 4, len(JOINT_NAMES), 14, 14)
    torch.testing.assert_close(heat.exp().sum((-1, -2)), torch.ones(3, 4, len(JOINT_NAMES)))


def sample_of(video: torch.Tensor) -> Sample:
    sample = Sample.__new__(Sample)  # the recognizer may look at the video only
    sample["video"] = video
    return sample


def test_a_saved_recognizer_answers_as_before(tmp_path: Path) -> None:
    torch.manual_seed(1)
    recognizer = NetworkRecognizer(ClipNetwork(), name="tiny")
    samples = [sample_of(one) for one in random_clips(3).video]
    samples.append(sample_of(random_clips(1, frames=2, seed=3).video[0]))
    before = recognizer.recognize(samples)
    recognizer.save(tmp_path / "tiny.safetensors", training={"epochs": 0})
    after = NetworkRecognizer.from_file(tmp_path / "tiny.safetensors")
    assert after.name == "tiny"
    for old, new in zip(before, after.recognize(samples), strict=True):
        assert (old.label, old.scores) == (new.label, new.scores)
        assert old.scores is not None
        assert sum(old.scores) == pytest.approx(1.0, abs=1e-5)
        assert old.label == EMOTIONS[int(np.argmax(old.scores))]


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="train_recognizer"):
        NetworkRecognizer.from_file(tmp_path / "none.safetensors")
    text = tmp_path / "text.safetensors"
    text.write_bytes(b"\x80\x04pickled or otherwise not what it should be")
    with pytest.raises(ValueError, match=r"text\.safetensors: must be a file in safetensors"):
        NetworkRecognizer.from_file(text)
    strange = tmp_path / "strange.safetensors"
    save_file({"weight": torch.zeros(2)}, str(strange), metadata={"format": "another"})
    with pytest.raises(ValueError, match="got format 'another'"):
        NetworkRecognizer.from_file(strange)
    save_file(
        {"weight": torch.zeros(2)}, str(strange), metadata={"format": "affectsim-clip-network-1"}
    )
    with pytest.raises(ValueError, match="weights do not fit"):
        NetworkRecognizer.from_file(strange)


def test_mirroring_swaps_left_and_right() -> None:
    mirrored = training._MIRRORED
    assert [mirrored[place] for place in mirrored] == list(range(len(JOINT_NAMES)))
    for place, other in enumerate(mirrored):
        names = {JOINT_NAMES[place], JOINT_NAMES[other]}
        assert len(names) == (1 if "left" not in "".join(names) else 2)


def test_joints_follow_the_changed_images() -> None:
    places = torch.tensor([[0.5, 0.5], [0.4, 0.55], [0.6, 0.45], [0.45, 0.6]] * 4)
    joint = JOINT_NAMES.index("pelvis")
    clips = dotted_clips(places, joint=joint)
    images, moved = training._changed(clips.video, clips.joints, torch.Generator().manual_seed(2))
    light = images[:, 0].mean(dim=1)
    light = (light - light.amin(dim=(1, 2), keepdim=True)).square()
    total = light.sum(dim=(1, 2))
    centres = (torch.arange(INPUT_SIZE) + 0.5) / INPUT_SIZE
    found = torch.stack(
        [(light.sum(dim=1) * centres).sum(1) / total, (light.sum(dim=2) * centres).sum(1) / total],
        dim=1,
    )
    assert (found - moved[:, 0, joint]).abs().max() < 0.01
    assert (found - places).abs().max() > 0.05, "nothing was changed"


def test_it_learns_where_joints_are() -> None:
    generator = torch.Generator().manual_seed(0)
    places = 0.3 + 0.4 * torch.rand((40, 2), generator=generator)
    joint = JOINT_NAMES.index("head")
    clips = dotted_clips(places, joint=joint)
    network = train_network(clips, joint_epochs=12, emotion_epochs=0, seed=0, progress=False)
    with torch.inference_mode():
        _, log_heat = network.look_at(clips.video)
    best = log_heat[:, 0, joint].flatten(1).argmax(dim=1)
    found = torch.stack([best % 14, best // 14], dim=1)
    near = ((found + 0.5) / 14 - places).abs().amax(dim=1) < 1.5 / 14
    assert near.float().mean() > 0.9


def test_training_is_repeatable_and_leaves_the_global_seed_alone() -> None:
    clips = random_clips(3, frames=2)
    torch.manual_seed(123)
    expected = torch.rand(3)
    torch.manual_seed(123)
    first = train_network(clips, joint_epochs=2, emotion_epochs=2, seed=5, progress=False)
    assert torch.equal(torch.rand(3), expected)
    again = train_network(clips, joint_epochs=2, emotion_epochs=2, seed=5, progress=False)
    other = train_network(clips, joint_epochs=2, emotion_epochs=2, seed=6, progress=False)
    for name in ("heat.weight", "answer.1.weight"):
        weights = [one.state_dict()[name] for one in (first, again, other)]
        assert torch.equal(weights[0], weights[1])
        assert not torch.equal(weights[0], weights[2])


@pytest.mark.egl
def test_joints_are_where_the_camera_projects_them(small: Release) -> None:
    dataset = AffectSimDataset(small, split="train", condition="p_ref")
    sample = dataset[0]
    clips = load_clips(dataset.subset([0]), progress=False)
    assert clips.video.shape == (1, 8, 3, INPUT_SIZE, INPUT_SIZE)
    assert clips.labels.tolist() == [sample["label"]]
    camera = small.manifest.camera
    for frame in (0, 5):
        T_camera_world = np.linalg.inv(sample["T_world_camera"][frame].numpy())
        points = sample["joint_positions"][frame].double().numpy()
        pixels, _ = camera.project(points @ T_camera_world[:3, :3].T + T_camera_world[:3, 3])
        expected = pixels / [camera.width, camera.height]
        np.testing.assert_allclose(clips.joints[0, frame].numpy(), expected, atol=1e-4)
