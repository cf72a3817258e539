"""Conditions: each turns an episode and its world into a camera trajectory."""

from affectsim_data.observations.active import AObs
from affectsim_data.observations.condition import Condition
from affectsim_data.observations.orbit import Orbit
from affectsim_data.observations.recordings import RecordedRuns
from affectsim_data.observations.reference import (
    PRef,
    ReferencePlanner,
    ReferenceSearch,
    plan_reference,
    reference_planner,
)
from affectsim_data.observations.still import PInit, PMon, head_camera_pose, monitor_pose
from affectsim_data.observations.tracks import BodyTrack, body_track

__all__ = [
    "AObs",
    "BodyTrack",
    "Condition",
    "Orbit",
    "PInit",
    "PMon",
    "PRef",
    "RecordedRuns",
    "ReferencePlanner",
    "ReferenceSearch",
    "body_track",
    "head_camera_pose",
    "monitor_pose",
    "plan_reference",
    "reference_planner",
]
