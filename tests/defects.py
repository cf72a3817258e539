"""Breaks motion on purpose, in eight ways that recordings break, so that screening can be tested.

Every defect is put into a take: world positions and rotations of joints that are aligned with the
canonical body, as a recording would hold them. Sizes are drawn at random from the ranges below. A
defect nobody could see is not one: a swap that moves no hand or foot by `MIN_SHOWN_M`, or dropped
frames in which nothing moves that far, is drawn again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np

from affectsim_data.motions import Motion
from affectsim_data.motions.inverse_kinematics import align_bone, two_bone_ik
from affectsim_data.motions.joint_frames import SourcePose, frame_offsets
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS

SIDES = ("left", "right")
MIN_SHOWN_M = 0.08
FACTOR = (1.15, 1.4)
SWAP_SHARE, KNEE_SHARE = (0.10, 0.40), (0.10, 0.40)
JUMP_M, DRAG_M, SUNK_M, TOE_M = (0.3, 1.0), (0.10, 0.30), (0.05, 0.20), (0.05, 0.10)
SUNK_SHARE, FROZEN_SHARE = (0.20, 0.60), (0.40, 0.80)
KNEE_DEG = (15.0, 60.0)
BLOCK_S = (0.15, 0.5)
_DRAWS = 40


class NotPossibleError(Exception):
    """This take has no place for the defect: no stance, say, or nothing moves."""


@dataclasses.dataclass
class Take:
    """A skeleton in motion as a tree: local positions and rotations of canonical joints."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    local_positions: FloatArray
    local_rotations: FloatArray
    fps: float

    @property
    def num_frames(self) -> int:
        return len(self.local_positions)

    def world(self) -> tuple[FloatArray, FloatArray]:
        """Positions `(num_frames, num_joints, 3)` and rotations `(..., 4)`."""
        positions, rotations = self.local_positions.copy(), self.local_rotations.copy()
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                above = rotations[:, parent]
                positions[:, joint] = positions[:, parent] + quaternion_rotate(
                    above, positions[:, joint]
                )
                rotations[:, joint] = quaternion_multiply(above, rotations[:, joint])
        return positions, rotations

    def source(self) -> SourcePose:
        """The take as an importer sees it."""
        positions, rotations = self.world()
        zero = BODY.rest_positions[[JOINT_NAMES.index(name) for name in self.names]]
        return SourcePose(
            self.names, positions, rotations, zero.copy(), np.array([0.0, 1.0, 0.0]), self.fps
        )

    def copy(self) -> Take:
        return dataclasses.replace(
            self,
            local_positions=self.local_positions.copy(),
            local_rotations=self.local_rotations.copy(),
        )

    def set_world(self, positions: FloatArray, rotations: FloatArray) -> None:
        """Sets every joint by its place in the world."""
        for joint, parent in enumerate(self.parents):
            if parent < 0:
                self.local_positions[:, joint] = positions[:, joint]
                self.local_rotations[:, joint] = rotations[:, joint]
                continue
            back = quaternion_conjugate(rotations[:, parent])
            away = positions[:, joint] - positions[:, parent]
            self.local_positions[:, joint] = quaternion_rotate(back, away)
            self.local_rotations[:, joint] = quaternion_multiply(back, rotations[:, joint])

    def index(self, name: str) -> int:
        return self.names.index(name)


def take_of(source: SourcePose, joints: Mapping[str, str]) -> Take:
    """The mapped joints of a recording, their frames aligned with the canonical body."""
    index = {name: source.joint_names.index(joints[name]) for name in JOINT_NAMES if name in joints}
    offsets = frame_offsets(source, index)
    names = tuple(name for name in JOINT_NAMES if name in offsets)
    places = [index[name] for name in names]
    rotations = np.stack(
        [quaternion_multiply(source.rotations[:, index[n]], offsets[n]) for n in names], axis=1
    )
    take = Take(
        names,
        _parents(names),
        np.zeros((source.num_frames, len(names), 3)),
        np.zeros_like(rotations),
        source.fps,
    )
    take.set_world(source.positions[:, places], rotations)
    return take


def take_of_motion(motion: Motion) -> Take:
    """A canonical motion as a recording of the canonical body."""
    offsets = np.tile(BODY.joint_offsets, (motion.num_frames, 1, 1))
    offsets[:, 0] = motion.root_translation
    return Take(JOINT_NAMES, JOINT_PARENTS, offsets, motion.joint_rotations.copy(), motion.fps)


def _parents(names: tuple[str, ...]) -> tuple[int, ...]:
    parents = []
    for name in names:
        above = JOINT_PARENTS[JOINT_NAMES.index(name)]
        while above >= 0 and JOINT_NAMES[above] not in names:
            above = JOINT_PARENTS[above]
        parents.append(names.index(JOINT_NAMES[above]) if above >= 0 else -1)
    return tuple(parents)


def scaled_bone(take: Take, rng: np.random.Generator) -> str:
    """One bone too long: a limb bone of one side for good, or any bone for a stretch."""
    factor = rng.uniform(*FACTOR)
    if rng.random() < 0.5:
        name = f"{rng.choice(SIDES)}_{rng.choice(['knee', 'ankle', 'elbow', 'wrist'])}"
        take.local_positions[:, take.index(name)] *= factor
        return f"{name} x {factor:.2f} for good"
    lengths = np.linalg.norm(take.local_positions, axis=-1).mean(axis=0)
    long = [n for i, n in enumerate(take.names) if take.parents[i] >= 0 and lengths[i] > 0.04]
    name = str(rng.choice(long))
    start, end = _stretch(take, rng, (0.1, 0.5))
    take.local_positions[start:end, take.index(name)] *= factor
    return f"{name} x {factor:.2f} in [{start}, {end})"


def swapped_limb(take: Take, rng: np.random.Generator) -> str:
    """Both arms or both legs exchanged, as swapped markers do: places too, or directions only."""
    limb = str(rng.choice(["arm", "leg"]))
    joints = ["shoulder", "elbow", "wrist"] if limb == "arm" else ["hip", "knee", "ankle", "foot"]
    parts = [part for part in joints if f"left_{part}" in take.names]
    left, right = ([take.index(f"{side}_{part}") for part in parts] for side in SIDES)
    half_turn = np.array([0.0, 0.0, 0.0, 1.0] if limb == "arm" else [1.0, 0.0, 0.0, 0.0])
    places = bool(rng.random() < 0.5)
    positions, rotations = take.world()
    end_joint = 2
    for _ in range(_DRAWS):
        start, end = _stretch(take, rng, SWAP_SHARE)
        swapped = take.copy()
        moved, turned = positions.copy(), rotations.copy()
        for one, other in ((left, right), (right, left)):
            turned[start:end, one] = quaternion_multiply(rotations[start:end, other], half_turn)
            moved[start:end, one] = positions[start:end, other]
        swapped.set_world(moved, turned)
        if not places:
            swapped.local_positions = take.local_positions.copy()
        now = swapped.world()[0]
        ends = [left[end_joint], right[end_joint]]
        edges = [start, end - 1]
        shown = np.linalg.norm((now - positions)[edges][:, ends], axis=-1)
        if shown.min() >= MIN_SHOWN_M:
            take.local_positions[:] = swapped.local_positions
            take.local_rotations[:] = swapped.local_rotations
            return f"{limb}s exchanged ({'places' if places else 'directions'}) in [{start}, {end})"
    raise NotPossibleError


def teleport(take: Take, rng: np.random.Generator) -> str:
    """The root jumps over the floor, for good or until it jumps back."""
    start, end = _stretch(take, rng, (0.1, 0.5))
    if rng.random() < 0.5:
        end = take.num_frames
    distance, way = rng.uniform(*JUMP_M), _floor_direction(rng)
    take.local_positions[start:end, 0] += distance * way
    return f"{distance:.2f} m in [{start}, {end})"


def slid_foot(take: Take, rng: np.random.Generator) -> str:
    """A standing foot dragged over the floor: with the whole body, or alone, by its leg."""
    side = str(rng.choice(SIDES))
    runs = _stances(take, side)
    if not runs:
        side = "right" if side == "left" else "left"
        runs = _stances(take, side)
    if not runs:
        raise NotPossibleError
    first, last = runs[int(rng.integers(len(runs)))]
    length = min(last - first, round(rng.uniform(0.3, 0.6) * take.fps))
    start = int(rng.integers(first, last - length + 1))
    drag = rng.uniform(*DRAG_M) * _floor_direction(rng)
    share = np.zeros(take.num_frames)
    share[start : start + length] = _smooth(np.arange(1, length + 1) / length)
    share[start + length :] = 1.0
    if rng.random() < 0.5:
        take.local_positions[:, 0] += share[:, None] * drag
        return f"whole body {np.linalg.norm(drag):.2f} m from {start} over {length} frames"
    # It stays where it was dragged until it is lifted, and comes back in the air.
    fade = max(round(0.25 * take.fps), 1)
    stop = min(max(last, start + length), take.num_frames)
    tail = np.clip(1.0 - np.arange(1, take.num_frames - stop + 1) / fade, 0.0, 1.0)
    share[stop:] = _smooth(tail)
    ankle = take.index(f"{side}_ankle")
    before, whole = take.world()[0][:, ankle], take.copy()
    _move_ankle(take, side, share[:, None] * drag)
    left_over = take.world()[0][:, ankle] - before - share[:, None] * drag
    if np.abs(left_over[start:last]).max() > 0.01:
        # The leg is too short to follow: the foot would be lifted, not dragged.
        take.local_rotations = whole.local_rotations
        share[start + length :] = 1.0
        take.local_positions[:, 0] += share[:, None] * drag
        return f"whole body {np.linalg.norm(drag):.2f} m from {start} over {length} frames"
    return f"{side} foot {np.linalg.norm(drag):.2f} m from {start} over {length} frames"


def sunk_floor(take: Take, rng: np.random.Generator) -> str:
    """The body below the floor for part of the take, or toes through it while they stand."""
    side = str(rng.choice(SIDES))
    runs = [run for run in _stances(take, side) if f"{side}_foot" in take.names]
    if rng.random() < 0.3 and runs:
        first, last = runs[int(rng.integers(len(runs)))]
        # Down all the time would be how the foot was calibrated.
        last = min(last, first + max(round(0.3 * take.num_frames), round(0.3 * take.fps)))
        depth = rng.uniform(*TOE_M)
        toe = take.index(f"{side}_foot")
        length = np.linalg.norm(take.local_positions[:, toe], axis=-1)
        share = np.minimum(depth / length, 0.9) * _plateau(take, first, last, ramp_s=0.1)
        bend = np.arcsin(share)
        pitch = axis_angle_quaternion([1.0, 0.0, 0.0], bend)
        ankle = take.index(f"{side}_ankle")
        take.local_rotations[:, ankle] = quaternion_multiply(take.local_rotations[:, ankle], pitch)
        return f"{side} toes {depth:.2f} m down in [{first}, {last})"
    start, end = _stretch(take, rng, SUNK_SHARE)
    depth = rng.uniform(*SUNK_M)
    take.local_positions[:, 0, 1] -= depth * _plateau(take, start, end, ramp_s=0.2)
    return f"{depth:.2f} m down in [{start}, {end})"


def flipped_knee(take: Take, rng: np.random.Generator) -> str:
    """A knee bends backwards, within a tenth of a second, and stays so for a stretch."""
    side = str(rng.choice(SIDES))
    start, end = _stretch(take, rng, KNEE_SHARE)
    angle = np.deg2rad(rng.uniform(*KNEE_DEG))
    share = _plateau(take, start, end, ramp_s=0.1)[:, None]
    knee = take.index(f"{side}_knee")
    local = take.local_rotations[:, knee]
    flexion = 2.0 * np.arctan2(local[:, 1], local[:, 0])
    back = axis_angle_quaternion([1.0, 0.0, 0.0], -share[:, 0] * (flexion + angle))
    take.local_rotations[:, knee] = quaternion_multiply(back, local)
    return f"{side} knee bends {np.rad2deg(angle):.0f} degrees backwards in [{start}, {end})"


def frozen_hand(take: Take, rng: np.random.Generator) -> str:
    """Elbow and wrist, or the wrist alone, stop turning for 40 percent of the take or more.

    Only where they turn all the time before: what holds still now and then may do so once more.
    """
    for _ in range(_DRAWS):
        parts = ("elbow", "wrist") if rng.random() < 0.7 else ("wrist",)
        side = str(rng.choice(SIDES))
        start, end = _stretch(take, rng, FROZEN_SHARE)
        if rng.random() < 0.5:
            start, end = take.num_frames - (end - start), take.num_frames
        joints = [take.index(f"{side}_{part}") for part in parts]
        before = take.local_rotations[:start, joints]
        first = take.local_rotations[:, joints[0]]
        still = np.abs(np.diff(first, axis=0)).max(axis=1) < 1e-7
        if start < 5 or _turn_deg(before)[0] < 5.0 or still.mean() > 0.02:
            continue
        take.local_rotations[start:end, joints] = take.local_rotations[start, joints]
        return f"{side} {' and '.join(parts)} still in [{start}, {end})"
    raise NotPossibleError


def dropped_frames(take: Take, rng: np.random.Generator) -> str:
    """A block of frames lost, held, or played twice."""
    how = str(rng.choice(["lost", "held", "twice"]))
    positions = take.world()[0]
    for _ in range(_DRAWS):
        length = round(rng.uniform(*BLOCK_S) * take.fps)
        margin = max(round(0.1 * take.fps), 3)
        if take.num_frames < length + 2 * margin + 2:
            continue
        start = int(rng.integers(margin, take.num_frames - length - margin))
        moved = np.linalg.norm(positions[start + length] - positions[start], axis=-1).max()
        if moved < MIN_SHOWN_M:
            continue
        frames = np.arange(take.num_frames)
        if how == "lost":
            kept = np.concatenate([frames[:start], frames[start + length :]])
        elif how == "held":
            kept = np.where((frames >= start) & (frames < start + length), start, frames)
        else:
            kept = np.concatenate([frames[: start + length], frames[start:]])
        take.local_positions = take.local_positions[kept]
        take.local_rotations = take.local_rotations[kept]
        return f"{length} frames {how} from {start}, {moved:.2f} m"
    raise NotPossibleError


DEFECTS: dict[str, Callable[[Take, np.random.Generator], str]] = {
    "scaled_bone": scaled_bone,
    "swapped_limb": swapped_limb,
    "teleport": teleport,
    "slid_foot": slid_foot,
    "sunk_floor": sunk_floor,
    "flipped_knee": flipped_knee,
    "frozen_hand": frozen_hand,
    "dropped_frames": dropped_frames,
}
"""What breaks a take in place and says how, by kind; `NotPossibleError` where it cannot."""


def _stretch(take: Take, rng: np.random.Generator, share: tuple[float, float]) -> tuple[int, int]:
    """A random stretch of that share of the take, off both ends, half open."""
    length = max(round(rng.uniform(*share) * take.num_frames), 3)
    margin = max(round(0.02 * take.num_frames), 2)
    start = int(rng.integers(margin, max(take.num_frames - length - margin, margin + 1)))
    return start, min(start + length, take.num_frames - 1)


def _plateau(take: Take, start: int, end: int, *, ramp_s: float) -> FloatArray:
    """0 outside, 1 inside, smooth ramps within the stretch."""
    ramp = max(ramp_s * take.fps, 1.0)
    frames = np.arange(take.num_frames)
    return _smooth(np.clip(np.minimum((frames - start + 1) / ramp, (end - frames) / ramp), 0, 1))


def _stances(take: Take, side: str) -> list[tuple[int, int]]:
    """Stretches of 0.3 s or more in which the foot stands still and low."""
    positions, _ = take.world()
    names = [name for name in (f"{side}_ankle", f"{side}_foot") if name in take.names]
    feet = positions[:, [take.index(name) for name in names]]
    speed = np.linalg.norm(np.gradient(feet, axis=0), axis=-1).max(axis=1) * take.fps
    low = feet[..., 1] < np.percentile(feet[..., 1], 5.0, axis=0) + 0.03
    still = (speed < 0.15) & low.all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(start, end) for start, end in runs if end - start >= 0.3 * take.fps]


def _move_ankle(take: Take, side: str, offset: FloatArray) -> None:
    """Moves an ankle by `(num_frames, 3)` metres with the leg behind it, the foot kept as it is."""
    positions, rotations = take.world()
    hip, knee, ankle = (take.index(f"{side}_{part}") for part in ("hip", "knee", "ankle"))
    upper = float(np.linalg.norm(take.local_positions[0, knee]))
    lower = float(np.linalg.norm(take.local_positions[0, ankle]))
    target = positions[:, ankle] + offset - positions[:, hip]
    pole = quaternion_rotate(rotations[:, hip], [0.0, 0.0, 1.0])
    thigh, shank, axis = two_bone_ik(target, pole, upper, lower)
    down = np.array([0.0, -1.0, 0.0])
    rotations[:, hip] = align_bone(thigh, axis, down, [1.0, 0.0, 0.0])
    rotations[:, knee] = align_bone(shank, axis, down, [1.0, 0.0, 0.0])
    moved = np.any(offset != 0.0, axis=1)
    lengths = take.local_positions.copy()
    kept = take.local_rotations.copy()
    take.set_world(positions, rotations)
    take.local_positions = lengths
    take.local_rotations[~moved] = kept[~moved]


def _turn_deg(rotations: FloatArray) -> FloatArray:
    """Largest angle of each joint from its first rotation, degrees, `(num_joints,)`."""
    cosine = np.abs(np.sum(rotations * rotations[:1], axis=-1)).clip(0.0, 1.0)
    turned: FloatArray = np.rad2deg(2.0 * np.arccos(cosine)).max(axis=0)
    return turned


def _floor_direction(rng: np.random.Generator) -> FloatArray:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return np.array([np.cos(angle), 0.0, np.sin(angle)])


def _smooth(share: FloatArray) -> FloatArray:
    smooth: FloatArray = share * share * (3.0 - 2.0 * share)
    return smooth
