"""Conditions: each turns an episode and its world into a camera trajectory."""

from affectsim_data.observations.condition import Condition
from affectsim_data.observations.orbit import Orbit
from affectsim_data.observations.reference import PRef, ReferenceSearch, plan_reference
from affectsim_data.observations.still import PInit, PMon, head_camera_pose, monitor_pose

__all__ = [
    "Condition",
    "Orbit",
    "PInit",
    "PMon",
    "PRef",
    "ReferenceSearch",
    "head_camera_pose",
    "monitor_pose",
    "plan_reference",
]
