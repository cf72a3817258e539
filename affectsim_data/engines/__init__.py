"""Where the items of a large job are worked: on processes of this machine, or on a Ray cluster."""

from affectsim_data.engines.local import LocalEngine
from affectsim_data.engines.opening import ENGINES, EngineName, open_engine
from affectsim_data.engines.protocol import Engine
from affectsim_data.engines.ray_cluster import RayEngine

__all__ = ["ENGINES", "Engine", "EngineName", "LocalEngine", "RayEngine", "open_engine"]
