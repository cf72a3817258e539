"""The real clips tests may read, each as a source pose with the joints it is retargeted by."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from affectsim_data.builders.corpus_recipe import load_recipe
from affectsim_data.content import content_path
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.retargeting import SourcePose, source_pose

_CMU_M, _INCH_M = 0.05644, 0.0254
_EVERY = 3
"""Of Bandai-Namco's clips: enough to see every action, and to be done in seconds."""


def real_clips(realdata: Path) -> Iterator[tuple[str, SourcePose, dict[str, str]]]:
    """Name, pose and joint map of some of Bandai-Namco's clips, one of CMU's, Xia's and PyMO's.

    CMU's clip has a T-pose as its first frame, which recipes skip; here it is left in.
    """
    recipe = load_recipe(content_path("builders", "bandai_namco.toml"))
    cmu = _joints(spine1="LowerBack", spine3="Spine1", neck="Neck")
    for path in sorted((realdata / "bandai_namco").glob("**/*.bvh"))[::_EVERY]:
        source = source_pose(read_bvh(path), metres_per_unit=0.01)
        yield path.stem, source, recipe.joint_map(source.joint_names)
    for path in [realdata / "cmu" / "12_01_walk.bvh", *(realdata / "xia_styles").glob("*.bvh")]:
        yield path.stem, source_pose(read_bvh(path), metres_per_unit=_CMU_M), cmu
    for path in (realdata / "pymo_affect_walk").glob("*.bvh"):
        yield (
            path.stem,
            source_pose(read_bvh(path), metres_per_unit=_INCH_M),
            _joints(spine1="Spine"),
        )


def _joints(**trunk: str) -> dict[str, str]:
    joints = {"pelvis": "Hips", "head": "Head", **trunk}
    for side, name in (("left", "Left"), ("right", "Right")):
        joints |= {f"{side}_hip": f"{name}UpLeg", f"{side}_knee": f"{name}Leg"}
        joints |= {f"{side}_ankle": f"{name}Foot", f"{side}_foot": f"{name}ToeBase"}
        joints |= {f"{side}_collar": f"{name}Shoulder", f"{side}_shoulder": f"{name}Arm"}
        joints |= {f"{side}_elbow": f"{name}ForeArm", f"{side}_wrist": f"{name}Hand"}
    return joints
