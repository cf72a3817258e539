"""The data contract: the columns of every table, as Arrow schemas with descriptions.

`schemas/*.json` is the same contract, language neutral; a test holds the two equal, and
`python -m affectsim_data.schemas` rewrites the files after a change here.
"""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

__all__ = [
    "ASSET_TABLES",
    "SCHEMAS",
    "SCHEMA_VERSION",
    "PHASES",
    "ROBOT_ACTIONS",
    "SPLITS",
    "AssetTable",
    "Challenge",
    "Family",
    "Phase",
    "RobotAction",
    "Split",
    "TableName",
    "array_columns",
    "check_table",
    "read_array",
    "schema_to_json",
]

SCHEMA_VERSION = "4.0"
"""Of the data; moves apart from the version of the code."""

Split = Literal["train", "validation", "test"]
SPLITS: tuple[Split, ...] = get_args(Split)
Family = Literal["action_grounded", "observation_controlled", "dyadic"]
FAMILIES: tuple[Family, ...] = get_args(Family)
Challenge = Literal["far_visible", "rear_view", "partial_occlusion", "obstacle_detour"]
CHALLENGES: tuple[Challenge, ...] = get_args(Challenge)
TableName = Literal[
    "episodes", "index", "cells", "motions", "scenes", "avatars", "predictions", "trajectories"
]
RobotAction = Literal["move_forward", "turn_left", "turn_right", "hand_off", "stop"]
ROBOT_ACTIONS: tuple[RobotAction, ...] = get_args(RobotAction)
"""What the robot can do in a step."""
Phase = Literal["search", "approach", "collect"]
PHASES: tuple[Phase, ...] = get_args(Phase)
"""What it is about: looking for the person, going to a view of them, and from the handoff on
collecting."""
AssetTable = Literal["motions", "scenes", "avatars"]
ASSET_TABLES: tuple[AssetTable, ...] = get_args(AssetTable)

_TYPES: dict[str, pa.DataType] = {
    "string": pa.string(),
    "float64": pa.float64(),
    "float32": pa.float32(),
    "int64": pa.int64(),
    "int32": pa.int32(),
    "bool": pa.bool_(),
    "binary": pa.binary(),
    "list<int32>": pa.list_(pa.int32()),
    "list<float32>": pa.list_(pa.float32()),
    "list<string>": pa.list_(pa.string()),
}


@dataclasses.dataclass(frozen=True)
class _Column:
    name: str
    type: str
    description: str
    nullable: bool = False

    def field(self) -> pa.Field:
        metadata = {"description": self.description}
        return pa.field(self.name, _TYPES[self.type], nullable=self.nullable, metadata=metadata)


def _maybe(name: str, kind: str, description: str) -> _Column:
    return _Column(name, kind, description, nullable=True)


def _array(name: str, description: str) -> list[_Column]:
    return [
        _Column(name, "binary", f"{description}; little-endian, row-major"),
        _Column(f"{name}_dtype", "string", "NumPy name of its element type, for example `<f4`"),
        _Column(f"{name}_shape", "list<int32>", "Its shape"),
    ]


def _point(name: str, description: str, *, nullable: bool = False) -> list[_Column]:
    return [
        _Column(f"{name}_{axis}_m", "float64", f"{description}, {axis}, metres", nullable)
        for axis in "xyz"
    ]


_EPISODES = [
    _Column("episode_id", "string", "Unique in the release"),
    _Column("split", "string", "train, validation or test"),
    _Column("scene_split", "string", "Split by scene instead: no two of these share a scene"),
    _Column("group_id", "string", "What no two splits share: performer, performance or sequence"),
    _Column(
        "placement_id",
        "string",
        "Episodes that share anchor, start and challenge, and differ in emotion alone, share this",
    ),
    _Column("family", "string", "action_grounded, observation_controlled or dyadic"),
    _maybe(
        "challenge",
        "string",
        "far_visible, rear_view, partial_occlusion or obstacle_detour; null in other families",
    ),
    _Column("action", "string", "What the target does; inherited from the motion"),
    _Column(
        "emotion", "string", "angry, fearful, happy, neutral or sad; inherited from the motion"
    ),
    _Column("scene_id", "string", "Row of the scenes table"),
    _Column("motion_id", "string", "The target's row of the motions table"),
    _Column("performer_id", "string", "Who performed the target's motion"),
    _Column("avatar_id", "string", "The target's body, a row of the avatars table"),
    _Column("target", "int32", "Place of the target in its interaction sequence, 0 or 1; 0 alone"),
    *_point("anchor", "Where the target's performance frame stands on the floor"),
    _Column("facing_deg", "float64", "Yaw of that frame: 0 looks along +Z, counter-clockwise"),
    _maybe(
        "support",
        "string",
        "Seat or door of the scene the action is aligned with: `seat 7`, `door 2`, by place in it",
    ),
    _maybe("partner_motion_id", "string", "The other participant's motion; null alone"),
    _maybe("partner_performer_id", "string", "Who performed it"),
    _maybe("partner_avatar_id", "string", "The other participant's body"),
    *_point("partner_anchor", "The other participant's anchor", nullable=True),
    _maybe("partner_facing_deg", "float64", "The other participant's facing"),
    *_point("start", "Where the robot starts, on the floor"),
    _Column(
        "start_yaw_deg", "float64", "Robot yaw: 0 looks along -Z, counter-clockwise from above"
    ),
    _Column("phase_s", "float64", "Instant of the motion cycle at which clips begin, in [0, D)"),
    _Column("duration_s", "float64", "D, the length of one motion cycle; a clip lasts 2 D"),
    *_point("monitor", "The room monitor's camera"),
    _Column("monitor_yaw_deg", "float64", "Its yaw: 0 looks along -Z"),
    _Column("monitor_pitch_deg", "float64", "Its pitch: negative looks down"),
    _Column(
        "reference_azimuth_deg",
        "float64",
        "Of the reference camera to the facing, 0 in front; at instant 0 if it keeps its side",
    ),
    _Column("reference_distance_m", "float64", "Reference camera to body centre"),
    _Column("reference_height_m", "float64", "Reference camera above the floor"),
    _Column("reference_score", "float64", "Weighted sum of the five parts, in [0, 1]"),
    _Column("reference_visibility", "float64", "Mean visible body share over the cycle"),
    _Column("reference_alignment", "float64", "1 in front of the target, 0 behind"),
    _Column("reference_distance_fit", "float64", "1 at the preferred distance"),
    _Column("reference_framing", "float64", "1 where the body fills the image without leaving it"),
    _Column("reference_clearance", "float64", "1 where nothing is near the camera"),
    *_array(
        "reference_trajectory",
        "Reference camera over one cycle, knots evenly spaced from instant 0: x y z w x y z",
    ),
    _maybe("d_star_1m", "float64", "Shortest navmesh path from start to the 1 m ring, metres"),
    _maybe("d_star_3m", "float64", "The same for 3 m"),
    _maybe("d_star_5m", "float64", "The same for 5 m"),
    _maybe("d_star_1m_null", "string", "Why d_star_1m is null: empty or unreachable"),
    _maybe("d_star_3m_null", "string", "The same for 3 m"),
    _maybe("d_star_5m_null", "string", "The same for 5 m"),
    _Column("navmesh_sha256", "string", "Hash of the navmesh these distances were measured on"),
    _Column("agent_radius_m", "float64", "Robot radius of that navmesh"),
    _Column("initial_distance_m", "float64", "Start to anchor, Euclidean"),
    _Column("initial_bearing_deg", "float64", "Start seen from the target: 0 in front, 180 behind"),
    _Column("visible_share_init", "float64", "Mean visible body share at p_init over the cycle"),
    _Column("visible_share_ref", "float64", "The same at p_ref"),
    _Column("visible_share_mon", "float64", "The same at p_mon"),
    _Column("source", "string", "Corpus and file of the target's motion"),
    _Column("recipe", "string", "Recipe that built the release"),
    _Column("seed", "int64", "Seed of the recipe"),
    _Column("code_version", "string", "Version of the package that built the row"),
    _Column("schema_version", "string", "Version of this contract"),
]

_INDEX = (
    *("episode_id", "split", "scene_split", "group_id", "placement_id"),
    *("family", "challenge", "action", "emotion"),
    *("scene_id", "motion_id", "performer_id", "avatar_id", "target"),
    *("partner_motion_id", "partner_performer_id", "partner_avatar_id"),
)
"""Columns of the episodes that say what an episode is and which files it needs."""

_CELLS = [
    _Column("split", "string", "train, validation or test"),
    _Column("family", "string", "action_grounded, observation_controlled or dyadic"),
    _maybe("challenge", "string", "As in the episodes"),
    _Column("action", "string", "As in the episodes"),
    _Column("emotion", "string", "As in the episodes"),
    _Column("planned", "int64", "Episodes the recipe asks for"),
    _Column("composed", "int64", "Episodes there are"),
    _maybe("binding_constraint", "string", "What most of the missing ones failed at; null if none"),
]

_MOTIONS = [
    _Column("motion_id", "string", "Unique in the release"),
    _Column("performer_id", "string", "Who performed"),
    _Column("group_id", "string", "Source performance or interaction sequence"),
    _Column("emotion", "string", "angry, fearful, happy, neutral or sad: the label lives here"),
    _Column("action", "string", "What is done"),
    _Column("performance", "string", "What was performed, more closely: threaten, mourn, ..."),
    _Column("take", "int32", "Repetition by this performer of this action and emotion, from 0"),
    _Column("fps", "float64", "Frames per second"),
    _Column("num_frames", "int32", "Frames in one cycle"),
    _Column("duration_s", "float64", "Length of one cycle"),
    *_array("root_translation", "Pelvis in the performance frame, metres, (num_frames, 3)"),
    *_array("joint_rotations", "Joint in its parent, quaternions wxyz, (num_frames, 22, 4)"),
    _Column("source", "string", "Corpus and file, and what was done to it"),
    _Column("licence", "string", "Licence of the source"),
    _Column("provenance", "string", "What was done to the source, a JSON object"),
    _Column(
        "original_before",
        "int32",
        "Frames of the original that the cycle lacks and that come before those it keeps",
    ),
    _Column("kept_start", "int32", "First frame of the cycle that is one of the original"),
    _Column("kept_stop", "int32", "Frame after the last; all of them if no loop was closed"),
    *_array("original_root_translation", "Frames of the original that the cycle lacks"),
    *_array("original_joint_rotations", "The same, (n, 22, 4); none if no loop was closed"),
]

_SCENES = [
    _Column("scene_id", "string", "Unique in the release"),
    _Column("glb", "binary", "glTF 2.0; its rooms, seats, doors and things are its extras"),
    _Column("num_triangles", "int32", "Triangles drawn"),
    _Column("rooms", "list<string>", "Purpose of each room"),
    _Column("num_seats", "int32", "Places to sit"),
    _Column("num_doors", "int32", "Doors to knock at"),
    _Column("area_m2", "float64", "Floor a robot can stand on"),
    _Column("navmesh", "binary", "Navigation mesh, see docs/formats.md"),
    _Column("navmesh_sha256", "string", "Hash of those bytes"),
    _Column("mesh_sha256", "string", "Hash of the geometry it was built from"),
    _Column("agent_radius_m", "float64", "Robot radius it was built for"),
    _Column("source", "string", "Where the scene comes from"),
    _Column("licence", "string", "Its licence"),
]

_AVATARS = [
    _Column("avatar_id", "string", "Unique in the release"),
    _Column(
        "glb", "binary", "glTF 2.0 with one skin of the 22 joints; meshes are levels of detail"
    ),
    _Column("height_m", "float64", "Standing height"),
    _Column("num_triangles", "int32", "Triangles of the finest level"),
    _Column("source", "string", "Where the body comes from"),
    _Column("licence", "string", "Its licence"),
]

_PREDICTIONS = [
    _Column("episode_id", "string", "Row of the episodes table"),
    _Column("condition", "string", "p_init, p_ref, p_mon, a_obs or a name of the user's"),
    _Column("model", "string", "Recognizer and its configuration"),
    _maybe("raw_text", "string", "What the model said, as it said it"),
    _maybe("label", "string", "One of the five emotions; null where it is still to be parsed"),
    _maybe("scores", "list<float32>", "One score per emotion, in label order"),
    _maybe("latency_ms", "float64", "Time to this prediction"),
    _maybe("frames_sha256", "string", "Hash of the frames the model saw"),
]

_TRAJECTORIES = [
    _Column("episode_id", "string", "Row of the episodes table"),
    _Column("policy", "string", "What moved the robot"),
    _Column("step", "int32", "Action number, from 0"),
    _Column("time_s", "float64", "Since the start of the episode"),
    _Column("action", "string", "move_forward, turn_left, turn_right, hand_off or stop"),
    *_point("position", "Robot on the floor after the action"),
    _Column("yaw_deg", "float64", "Robot yaw after the action: 0 looks along -Z"),
    _Column("clipped", "bool", "Whether the move was cut short by the navmesh or a person"),
    _Column("phase", "string", "search, approach or collect"),
    _Column("planner_calls", "int32", "Planner calls so far"),
]


SCHEMAS: dict[TableName, pa.Schema] = {
    "episodes": pa.schema([column.field() for column in _EPISODES]),
    "index": pa.schema([column.field() for column in _EPISODES if column.name in _INDEX]),
    "cells": pa.schema([column.field() for column in _CELLS]),
    "motions": pa.schema([column.field() for column in _MOTIONS]),
    "scenes": pa.schema([column.field() for column in _SCENES]),
    "avatars": pa.schema([column.field() for column in _AVATARS]),
    "predictions": pa.schema([column.field() for column in _PREDICTIONS]),
    "trajectories": pa.schema([column.field() for column in _TRAJECTORIES]),
}
"""Arrow schema of every table; field metadata carries the descriptions."""


def schema_to_json(table: TableName) -> dict[str, Any]:
    """The language-neutral twin of a schema, as it stands in `schemas/TABLE.json`."""
    names = {dtype: name for name, dtype in _TYPES.items()}
    columns = [
        {
            "name": field.name,
            "type": names[field.type],
            "nullable": field.nullable,
            "description": field.metadata[b"description"].decode(),
        }
        for field in SCHEMAS[table]
    ]
    return {"table": table, "schema_version": SCHEMA_VERSION, "columns": columns}


def check_table(schema: pa.Schema, table: TableName, *, file: str) -> None:
    """Raises ValueError if a file's columns are not those of the contract.

    Args:
        schema: What the file has.
        table: What it should be.
        file: What the message calls it.
    """
    expected = SCHEMAS[table]
    missing = [name for name in expected.names if name not in schema.names]
    if missing:
        raise ValueError(f"{file}: {table} columns are missing: {', '.join(missing)}")
    wrong = [
        f"{name} must be {expected.field(name).type}, got {schema.field(name).type}"
        for name in expected.names
        if schema.field(name).type != expected.field(name).type
    ]
    if wrong:
        raise ValueError(f"{file}: {table} columns have the wrong type: {'; '.join(wrong)}")


_ARRAY_DTYPES = ("<f4", "<f8", "<i4", "<i8", "|u1")


def array_columns(name: str, array: NDArray[Any]) -> dict[str, Any]:
    """The three columns that store an array: bytes, dtype, shape."""
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    if little.dtype.str not in _ARRAY_DTYPES:
        raise ValueError(f"{name}: dtype must be one of {_ARRAY_DTYPES}, got {array.dtype}")
    return {
        name: little.tobytes(),
        f"{name}_dtype": little.dtype.str,
        f"{name}_shape": list(little.shape),
    }


def read_array(row: dict[str, Any], name: str, *, where: str) -> NDArray[Any]:
    """The array of such columns; `where` names the row in errors.

    Raises:
        ValueError: Unknown dtype, or the bytes do not fill the shape.
    """
    payload, dtype, shape = row[name], row[f"{name}_dtype"], row[f"{name}_shape"]
    if dtype not in _ARRAY_DTYPES:
        raise ValueError(f"{where}: {name}_dtype must be one of {_ARRAY_DTYPES}, got {dtype!r}")
    # Exact integers: a shape that lies may not wrap round to the right number of bytes.
    count = math.prod(shape) if min(shape, default=0) >= 0 else -1
    expected = count * np.dtype(dtype).itemsize
    if expected != len(payload):
        raise ValueError(
            f"{where}: {name} with shape {tuple(shape)} of {dtype} needs {expected} bytes, "
            f"got {len(payload)}"
        )
    return np.frombuffer(payload, dtype).reshape(shape)


def write_json_twins(folder: Path) -> None:
    """Writes `TABLE.json` for every table."""
    for table in SCHEMAS:
        text = json.dumps(schema_to_json(table), indent=2) + "\n"
        (folder / f"{table}.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    from affectsim_data.content import content_path

    write_json_twins(content_path("schemas"))
