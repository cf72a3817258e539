"""Where the person stands and where the robot starts: pools of candidates, then measured.

A scene has pools of a thousand and more pairs of a place and a start, for each kind of placement
and each challenge, filtered by what holds for any body. A slot draws from a pool, puts its own
motions there and measures them: a placement is kept only if it holds under *all* emotions, so that
nothing but the motion depends on the emotion.
"""

from affectsim_data.builders.placement.search import find_placements
from affectsim_data.builders.placement.stages import Placement, Stage, Unplaced

__all__ = ["Placement", "Stage", "Unplaced", "find_placements"]
