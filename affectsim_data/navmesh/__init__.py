"""Where a robot can go: `NavMesh.from_mesh(vertices, faces)`, its distances and its moves."""

from affectsim_data.navmesh.mesh import NavMesh, StepResult
from affectsim_data.navmesh.settings import Settings

__all__ = ["NavMesh", "Settings", "StepResult"]
