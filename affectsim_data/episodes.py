"""The episode e = C(m, S, p_h, x0, c): a replayable configuration, and the world it describes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike

from affectsim_data.avatars import Avatar
from affectsim_data.cameras import Camera
from affectsim_data.motions import EMOTIONS, Emotion, Motion, emotion_label
from affectsim_data.poses import FloatArray, compose_pose, yaw_quaternion
from affectsim_data.scenes import Scene
from affectsim_data.schemas import (
    CHALLENGES,
    FAMILIES,
    SCHEMA_VERSION,
    SCHEMAS,
    SPLITS,
    Challenge,
    Family,
    Split,
    array_columns,
    read_array,
)

__all__ = [
    "ACTION_RATE_HZ",
    "STEP_M",
    "TURN",
    "CLIP_FPS",
    "RING_DISTANCES_M",
    "Episode",
    "Participant",
    "Person",
    "ReferenceView",
    "Robot",
    "World",
    "clip_time_s",
]

CLIP_FPS = 30.0
"""Rate of the grid that every clip's frames lie on."""
RING_DISTANCES_M = (1, 3, 5)
"""Target distances r of d*(r)."""
NO_D_STAR = ("empty", "unreachable")
"""Why there may be no d*(r): the ring holds no navigable point, or none that can be reached."""
_REFERENCE_PARTS = ("visibility", "alignment", "distance_fit", "framing", "clearance")
_CLOSED: tuple[tuple[str, tuple[str | None, ...]], ...] = (
    ("emotion", EMOTIONS),
    ("split", SPLITS),
    ("scene_split", SPLITS),
    ("family", FAMILIES),
    ("challenge", (*CHALLENGES, None)),
)
"""Fields with a closed set of words."""
_REQUIRED = tuple(field.name for field in SCHEMAS["episodes"] if not field.nullable)
_FLOATS = tuple(f.name for f in SCHEMAS["episodes"] if pa.types.is_float64(f.type))
_PARTNER = tuple(name for name in SCHEMAS["episodes"].names if name.startswith("partner_"))


ACTION_RATE_HZ = 4.0
"""Actions of the robot a second (paper, "Execution settings"); the person keeps moving."""
STEP_M = 0.25
"""Length of a move forward (paper, "Execution settings")."""
TURN = math.radians(15.0)
"""Angle of a turn (paper, "Execution settings")."""


@dataclasses.dataclass(frozen=True)
class Robot:
    """The observer's body: Fetch, as DESIGN fixes it; a parameter of the release."""

    radius_m: float = 0.30
    """Footprint radius."""
    height_m: float = 1.5
    """Free height it needs."""
    camera_height_m: float = 1.2
    """Height of the level head camera."""


@dataclasses.dataclass(frozen=True)
class Participant:
    """One person of the human placement p_h: who does what, where."""

    motion_id: str
    """What is performed."""
    performer_id: str
    """By whom."""
    avatar_id: str
    """In which body."""
    anchor: tuple[float, float, float]
    """Origin of the performance frame in the world, metres."""
    facing: float
    """Yaw of the performance frame, radians: 0 looks along +Z."""

    @property
    def T_world_performance(self) -> FloatArray:
        """The performance frame in the world, `(4, 4)`."""
        return compose_pose(yaw_quaternion(self.facing), np.array(self.anchor))


@dataclasses.dataclass(frozen=True)
class ReferenceView:
    """The privileged reference camera, and why it stands there."""

    azimuth: float
    """To the target's facing, radians, 0 in front, positive to the target's left."""
    distance_m: float
    """To the body centre."""
    height_m: float
    """Above the floor."""
    score: float
    """Weighted sum of the parts."""
    parts: Mapping[str, float]
    """`visibility, alignment, distance_fit, framing, clearance`, each in [0, 1]."""
    knots: FloatArray = dataclasses.field(compare=False)
    """Camera over one cycle, evenly spaced from instant 0: position and quaternion, `(n, 7)`."""


@dataclasses.dataclass(frozen=True)
class Episode:
    """One row of a release: everything needed to replay and re-observe a performance."""

    episode_id: str
    split: Split
    scene_split: Split
    """The other way to part episodes: by scene."""
    group_id: str
    placement_id: str
    """Shared by episodes that differ in emotion alone."""
    family: Family
    challenge: Challenge | None
    action: str
    emotion: Emotion
    scene_id: str
    target: Participant
    """Whose emotion is asked for."""
    support: str | None
    """Seat or door the action is aligned with, by its place in the scene: `seat 7`, `door 2`."""
    partner: Participant | None
    """The other participant of a dyad."""
    target_index: int
    """Place of the target in the interaction sequence."""
    start_position: tuple[float, float, float]
    """Robot on the floor, metres."""
    start_yaw: float
    """Radians: 0 looks along -Z."""
    phase_s: float
    """Instant of the cycle at which clips begin."""
    duration_s: float
    """D, one motion cycle."""
    monitor_position: tuple[float, float, float]
    """Camera of the room monitor, metres."""
    monitor_yaw: float
    """Radians: 0 looks along -Z."""
    monitor_pitch: float
    """Radians: negative looks down."""
    reference: ReferenceView
    d_star: Mapping[int, float | str]
    """Metres by ring distance, or why there is none: `empty`, `unreachable`."""
    navmesh_sha256: str
    agent_radius_m: float
    initial_bearing: float
    """Of the start, seen from the target, radians off its facing, in (-pi, pi]."""
    visible_share_init: float
    visible_share_ref: float
    visible_share_mon: float
    source: str
    recipe: str
    seed: int
    code_version: str

    def __post_init__(self) -> None:
        name = f"episode {self.episode_id!r}"
        for field, allowed in _CLOSED:
            if getattr(self, field) not in allowed:
                raise ValueError(
                    f"{name}: {field} must be one of {allowed}, got {getattr(self, field)!r}"
                )
        for r in RING_DISTANCES_M:
            value = self.d_star.get(r)
            if value not in NO_D_STAR and (not isinstance(value, float | int) or value < 0.0):
                raise ValueError(
                    f"{name}: d_star at {r} m must be a length or one of {NO_D_STAR}, got {value!r}"
                )
        if not 0.0 <= self.phase_s < self.duration_s:
            raise ValueError(
                f"{name}: phase_s must be in [0, {self.duration_s:g}), got {self.phase_s:g}"
            )

    @property
    def label(self) -> int:
        """Index of the emotion in label order."""
        return emotion_label(self.emotion)

    @property
    def participants(self) -> tuple[Participant, ...]:
        """The target, then its partner if there is one."""
        return (self.target,) if self.partner is None else (self.target, self.partner)

    @property
    def initial_distance_m(self) -> float:
        """Start to anchor, Euclidean."""
        return math.dist(self.start_position, self.target.anchor)

    def to_row(self) -> dict[str, Any]:
        """The row of the episodes table."""
        row: dict[str, Any] = {
            name: getattr(self, name)
            for name in (
                *("episode_id", "split", "scene_split", "group_id", "placement_id", "support"),
                *("family", "challenge", "action", "emotion"),
                *("scene_id", "phase_s", "duration_s", "navmesh_sha256", "agent_radius_m"),
                *("initial_distance_m", "visible_share_init", "visible_share_ref"),
                *("visible_share_mon", "source", "recipe", "seed", "code_version"),
            )
        }
        row |= {"schema_version": SCHEMA_VERSION, "target": self.target_index}
        row |= _participant_columns(self.target, "")
        row |= _participant_columns(self.partner, "partner_")
        row |= _point_columns("start", self.start_position)
        row |= _point_columns("monitor", self.monitor_position)
        for name in ("start_yaw", "monitor_yaw", "monitor_pitch", "initial_bearing"):
            row[f"{name}_deg"] = _degrees(getattr(self, name))
        row["reference_azimuth_deg"] = _degrees(self.reference.azimuth)
        for name in ("distance_m", "height_m", "score"):
            row[f"reference_{name}"] = getattr(self.reference, name)
        row |= {f"reference_{part}": self.reference.parts[part] for part in _REFERENCE_PARTS}
        row |= array_columns("reference_trajectory", self.reference.knots.astype("<f4"))
        for r in RING_DISTANCES_M:
            value = self.d_star[r]
            row[f"d_star_{r}m"] = None if isinstance(value, str) else value
            row[f"d_star_{r}m_null"] = value if isinstance(value, str) else None
        return row

    @classmethod
    def from_row(cls, row: dict[str, Any]) -> Episode:
        """Reads a row of the episodes table.

        Raises:
            ValueError: A value is out of its range; the message names the episode.
        """
        where = f"episode {row.get('episode_id')!r}"
        _check_row(row, where)
        plain: dict[str, Any] = {name: row[name] for name in _PLAIN}
        angles: dict[str, Any] = {
            name: math.radians(row[f"{name}_deg"])
            for name in ("start_yaw", "monitor_yaw", "monitor_pitch", "initial_bearing")
        }
        knots = _read_knots(row, where)
        reference = ReferenceView(
            azimuth=math.radians(row["reference_azimuth_deg"]),
            distance_m=row["reference_distance_m"],
            height_m=row["reference_height_m"],
            score=row["reference_score"],
            parts={part: row[f"reference_{part}"] for part in _REFERENCE_PARTS},
            knots=knots,
        )
        d_star = {
            r: row[f"d_star_{r}m_null"] if row[f"d_star_{r}m"] is None else row[f"d_star_{r}m"]
            for r in RING_DISTANCES_M
        }
        return cls(
            **plain,
            **angles,
            target=cast(Participant, _read_participant(row, "")),
            partner=_read_participant(row, "partner_"),
            target_index=row["target"],
            start_position=_read_point(row, "start"),
            monitor_position=_read_point(row, "monitor"),
            reference=reference,
            d_star=d_star,
        )


_PLAIN = tuple(
    field.name
    for field in dataclasses.fields(Episode)
    if field.name in SCHEMAS["episodes"].names and field.name != "target"
)
"""Fields that are columns as they are."""


def _read_knots(row: dict[str, Any], where: str) -> FloatArray:
    knots = read_array(row, "reference_trajectory", where=where).astype(np.float64)
    if knots.ndim != 2 or knots.shape[1] != 7 or not len(knots):
        raise ValueError(f"{where}: reference_trajectory must be (n, 7), got {knots.shape}")
    norms = np.sqrt(np.einsum("ij,ij->i", knots[:, 3:], knots[:, 3:]))
    if not (np.isfinite(knots).all() and np.abs(norms - 1.0).max() <= 1e-3):
        raise ValueError(f"{where}: reference_trajectory must hold finite unit quaternions")
    return knots


def _degrees(angle: float) -> float:
    """Rounded, so that a row read and written again is the same row."""
    return round(math.degrees(angle), 9)


def _check_row(row: Mapping[str, Any], where: str) -> None:
    # Looked up by `map`, which is several times faster than a loop: every sample comes this way.
    if None in map(row.get, _REQUIRED):
        missing = [name for name in _REQUIRED if row.get(name) is None]
        raise ValueError(f"{where}: columns may not be missing or null: {', '.join(missing)}")
    empty = [name for name in _PARTNER if row.get(name) is None]
    if empty and len(empty) < len(_PARTNER):
        raise ValueError(f"{where}: of a partner's columns these are null: {', '.join(empty)}")
    # Null and zero are left out; both are fine.
    if not all(map(math.isfinite, filter(None, map(row.get, _FLOATS)))):
        wild = [name for name in _FLOATS if not math.isfinite(row.get(name) or 0.0)]
        raise ValueError(f"{where}: columns must be finite: {', '.join(wild)}")


def _point_columns(name: str, point: tuple[float, float, float] | None) -> dict[str, Any]:
    values = (None, None, None) if point is None else point
    return {f"{name}_{axis}_m": value for axis, value in zip("xyz", values, strict=True)}


def _read_point(row: dict[str, Any], name: str) -> tuple[float, float, float]:
    return (row[f"{name}_x_m"], row[f"{name}_y_m"], row[f"{name}_z_m"])


def _participant_columns(person: Participant | None, prefix: str) -> dict[str, Any]:
    row: dict[str, Any] = {
        f"{prefix}{name}": getattr(person, name, None)
        for name in ("motion_id", "performer_id", "avatar_id")
    }
    row |= _point_columns(f"{prefix}anchor", None if person is None else person.anchor)
    row[f"{prefix}facing_deg"] = None if person is None else _degrees(person.facing)
    return row


def _read_participant(row: dict[str, Any], prefix: str) -> Participant | None:
    if row[f"{prefix}motion_id"] is None:
        return None
    return Participant(
        motion_id=row[f"{prefix}motion_id"],
        performer_id=row[f"{prefix}performer_id"],
        avatar_id=row[f"{prefix}avatar_id"],
        anchor=_read_point(row, f"{prefix}anchor"),
        facing=math.radians(row[f"{prefix}facing_deg"]),
    )


def clip_time_s(episode: Episode) -> FloatArray:
    """Motion instants of a clip, seconds, `(round(2 D fps),)`: two cycles from the phase.

    At least one, however short the cycle.
    """
    num_frames = max(1, round(2.0 * episode.duration_s * CLIP_FPS))
    return episode.phase_s + np.arange(num_frames) / CLIP_FPS


@dataclasses.dataclass(frozen=True)
class Person:
    """A participant made concrete: a motion in a body at a place."""

    motion: Motion
    avatar: Avatar
    T_world_performance: FloatArray
    """`(4, 4)`."""

    def joint_matrices(self, time_s: ArrayLike) -> FloatArray:
        """Rest vertices to world at motion instants `(n,)`, `(n, 22, 4, 4)`."""
        root, rotations = self.motion.sample(time_s)
        return self.avatar.joint_matrices(
            root, rotations, T_world_performance=self.T_world_performance
        )

    def joint_frames(self, time_s: ArrayLike) -> FloatArray:
        """Joint frames in the world at motion instants `(n,)`, `(n, 22, 4, 4)`."""
        root, rotations = self.motion.sample(time_s)
        return self.avatar.pose(root, rotations, T_world_performance=self.T_world_performance)


@dataclasses.dataclass(frozen=True)
class World:
    """What an episode's identifiers stand for: the scene, the people in it, the robot's camera."""

    scene: Scene
    people: tuple[Person, ...]
    """The target first."""
    camera: Camera
    robot: Robot

    @property
    def target(self) -> Person:
        """Whose emotion is asked for."""
        return self.people[0]
