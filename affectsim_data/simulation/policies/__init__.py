"""Policies: what moves the robot."""

from affectsim_data.simulation.policies.opening import open_policy, policy_names
from affectsim_data.simulation.policies.protocol import Decision, Policy, PrivilegedPolicy

__all__ = ["Decision", "Policy", "PrivilegedPolicy", "open_policy", "policy_names"]
