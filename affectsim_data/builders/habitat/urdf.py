"""Articulated objects: the visual shapes of a URDF, its joints held at given positions.

Read with the standard library: the URDF packages on PyPI bring a mesh loader and an XML parser of
their own, and we need poses of shapes alone.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from affectsim_data.poses import FloatArray, axis_angle_quaternion, quaternion_matrix

__all__ = ["Visual", "read_urdf"]

MAX_BYTES = 4 * 2**20
MAX_ELEMENTS = 100_000
_MOVABLE = ("revolute", "continuous", "prismatic")
Shape = Literal["mesh", "box", "cylinder", "sphere"]


@dataclasses.dataclass(frozen=True)
class Visual:
    """A visible shape of a link."""

    link: str
    shape: Shape
    pose: FloatArray
    """Takes points of the shape into the object's frame, `(4, 4)`; the scale of a mesh included."""
    mesh: str = ""
    """File of a mesh, as the URDF calls it."""
    size: tuple[float, ...] = ()
    """Sides of a box; radius and length of a cylinder along Z; radius of a sphere; metres."""


@dataclasses.dataclass(frozen=True)
class _Joint:
    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray
    axis: FloatArray

    def pose(self, position: float) -> FloatArray:
        """The child's frame in its parent's, `(4, 4)`."""
        motion = np.eye(4)
        if self.kind == "prismatic":
            motion[:3, 3] = self.axis * position
        elif self.kind in _MOVABLE:
            motion[:3, :3] = quaternion_matrix(axis_angle_quaternion(self.axis, position))
        return self.origin @ motion


def read_urdf(
    path: Path, *, where: str, joints: Mapping[str, float] | tuple[float, ...] = ()
) -> tuple[Visual, ...]:
    """The visible shapes of a URDF.

    Args:
        path: The file.
        where: What messages call it.
        joints: Positions by joint name, or of the movable joints in the order of the file; others
            are zero.

    Raises:
        ValueError: It is too large, no URDF, has a value that is no number, or its links are no
            tree; the message starts with `where`.
    """
    root = _parse(path, where)
    try:
        links = {_need(link, "name"): link for link in root.findall("link")}
        found = [_joint(element) for element in root.findall("joint")]
        frames = _link_frames(links, found, joints)
        return tuple(
            _visual(name, element, frames[name])
            for name, link in links.items()
            for element in link.findall("visual")
        )
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def _parse(path: Path, where: str) -> ElementTree.Element:
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise ValueError(f"{where}: has {size} bytes, more than the {MAX_BYTES} allowed")
    text = path.read_bytes()
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise ValueError(f"{where}: declares XML entities, which a URDF does not need; refused")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise ValueError(f"{where}: no valid XML: {error}") from error
    if root.tag != "robot":
        raise ValueError(f"{where}: no URDF: its root must be <robot>, got <{root.tag[:40]}>")
    if sum(1 for _ in root.iter()) > MAX_ELEMENTS:
        raise ValueError(f"{where}: has more than {MAX_ELEMENTS} elements")
    return root


def _link_frames(
    links: Mapping[str, ElementTree.Element],
    joints: list[_Joint],
    positions: Mapping[str, float] | tuple[float, ...],
) -> dict[str, FloatArray]:
    """Pose of every link in the frame of the root link."""
    children: dict[str, list[_Joint]] = {}
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise ValueError(f"joint {joint.name!r} names link {end!r}, which is not there")
        children.setdefault(joint.parent, []).append(joint)
    if not isinstance(positions, Mapping):
        movable = [joint.name for joint in joints if joint.kind in _MOVABLE]
        positions = dict(zip(movable, positions, strict=False))
    ends = {joint.child for joint in joints}
    roots = [name for name in links if name not in ends]
    frames: dict[str, FloatArray] = {name: np.eye(4) for name in roots}
    stack = list(roots)
    while stack:
        parent = stack.pop()
        for joint in children.get(parent, ()):
            if joint.child in frames:
                raise ValueError(f"link {joint.child!r} has two parents")
            frames[joint.child] = frames[parent] @ joint.pose(positions.get(joint.name, 0.0))
            stack.append(joint.child)
    lost = sorted(set(links) - set(frames))
    if lost:
        raise ValueError(f"links hang on no root but on one another: {', '.join(lost[:4])}")
    return frames


def _joint(element: ElementTree.Element) -> _Joint:
    name, kind = _need(element, "name"), element.get("type", "fixed")
    ends = [element.find(tag) for tag in ("parent", "child")]
    if ends[0] is None or ends[1] is None:
        raise ValueError(f"joint {name!r} needs a parent and a child")
    axis_element = element.find("axis")
    axis = np.array([1.0, 0.0, 0.0])
    if axis_element is not None:
        axis = np.array(_numbers(axis_element, "xyz", 3, (1.0, 0.0, 0.0)))
    length = float(np.linalg.norm(axis))
    if length == 0.0 and kind in _MOVABLE:
        raise ValueError(f"joint {name!r} has an axis of length 0")
    axis = axis / length if length else axis
    return _Joint(
        name, kind, _need(ends[0], "link"), _need(ends[1], "link"), _origin(element), axis
    )


def _visual(link: str, element: ElementTree.Element, frame: FloatArray) -> Visual:
    geometry = element.find("geometry")
    shapes = [] if geometry is None else list(geometry)
    if len(shapes) != 1:
        raise ValueError(f"a visual of link {link!r} needs one geometry, got {len(shapes)}")
    shape, pose = shapes[0], frame @ _origin(element)
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", 3, (1.0, 1.0, 1.0))
        return Visual(link, "mesh", pose @ np.diag([*scale, 1.0]), _need(shape, "filename"))
    if shape.tag == "box":
        return Visual(link, "box", pose, size=_sizes(shape, "size", 3))
    if shape.tag == "sphere":
        return Visual(link, "sphere", pose, size=_sizes(shape, "radius", 1))
    if shape.tag == "cylinder":
        size = (*_sizes(shape, "radius", 1), *_sizes(shape, "length", 1))
        return Visual(link, "cylinder", pose, size=size)
    raise ValueError(f"link {link!r} has a shape <{shape.tag[:40]}>, which no URDF has")


def _origin(element: ElementTree.Element) -> FloatArray:
    """The pose an element's `<origin>` gives it: roll, pitch, yaw about fixed X, Y, Z."""
    origin, pose = element.find("origin"), np.eye(4)
    if origin is not None:
        roll, pitch, yaw = _numbers(origin, "rpy", 3, (0.0, 0.0, 0.0))
        turns = zip(np.eye(3)[::-1], (yaw, pitch, roll), strict=True)
        for axis, angle in turns:
            pose[:3, :3] = pose[:3, :3] @ quaternion_matrix(axis_angle_quaternion(axis, angle))
        pose[:3, 3] = _numbers(origin, "xyz", 3, (0.0, 0.0, 0.0))
    return pose


def _need(element: ElementTree.Element, key: str) -> str:
    value = element.get(key)
    if not value:
        raise ValueError(f"<{element.tag}> needs {key}")
    return value


def _numbers(
    element: ElementTree.Element, key: str, count: int, default: tuple[float, ...] = ()
) -> tuple[float, ...]:
    text = element.get(key)
    if text is None and default:
        return default
    try:
        numbers = tuple(float(word) for word in (text or "").split())
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise ValueError(f"<{element.tag}> {key} must be {count} finite numbers, got {text!r:.60}")
    return numbers


def _sizes(element: ElementTree.Element, key: str, count: int) -> tuple[float, ...]:
    sizes = _numbers(element, key, count)
    if min(sizes) <= 0.0:
        raise ValueError(f"<{element.tag}> {key} must be above 0, got {element.get(key)!r:.60}")
    return sizes
