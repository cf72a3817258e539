"""Where the units of a build are worked: on processes of this machine, or on a Ray cluster."""

from affectsim_data.builders.engines.local import LocalEngine
from affectsim_data.builders.engines.opening import ENGINES, EngineName, open_engine
from affectsim_data.builders.engines.protocol import Engine
from affectsim_data.builders.engines.ray_cluster import RayEngine

__all__ = ["ENGINES", "Engine", "EngineName", "LocalEngine", "RayEngine", "open_engine"]
