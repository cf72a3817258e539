"""Every check there is: its name, what its values are, and what to do when it fails.

Limits are where values are measured; `docs/validation.md` lists them.
"""

from __future__ import annotations

from affectsim_data.builders.validation.findings import Check, Level

__all__ = ["CHECKS", "GROUPS"]

_REBUILD = "build the release again"
_FETCH = "build or fetch the release again"
_REPORT = "the composer let it through: build again and report it if it stays"
_RECORD = "record it again with `affectsim acquire --into-release`"
_RECIPE = "build again with a recipe that can be met, or correct its counts"

_ROWS: tuple[tuple[str, str, Level, str, str, str], ...] = (
    # name, group, level, unit, what its values are, what to do
    ("files", "integrity", "asset", "problems", "Files unlike their entry in the manifest", _FETCH),
    ("assets_readable", "integrity", "asset", "problems", "Assets that cannot be read", _FETCH),
    ("rows_readable", "integrity", "episode", "problems", "Rows a reader refuses", _REBUILD),
    ("ids_unique", "integrity", "episode", "rows", "Rows of that identifier", _REBUILD),
    ("index_agrees", "integrity", "episode", "columns", "Index columns unlike the row", _REBUILD),
    ("references", "integrity", "episode", "references", "Names of assets not there", _REBUILD),
    (
        *("motion_agrees", "integrity", "episode", "columns"),
        *("Columns unlike the motion's or the scene's", _REBUILD),
    ),
    (
        *("manifest_agrees", "integrity", "episode", "columns"),
        *("Columns unlike the manifest's recipe, seed, code or robot", _REBUILD),
    ),
    ("words", "integrity", "episode", "columns", "Columns with a word not allowed", _REBUILD),
    ("recipe", "integrity", "release", "problems", "Problems with the recipe inside", _REBUILD),
    ("licences", "integrity", "release", "licences", "Licences the manifest lacks", _REBUILD),
    (
        *("cells_agree", "counts", "release", "episodes"),
        *("Episodes there are, beyond what the cell says", _REBUILD),
    ),
    (
        *("cells_planned", "counts", "release", "episodes"),
        *("Episodes planned beyond the recipe's share", _REBUILD),
    ),
    ("cells_complete", "counts", "release", "share", "Share of a cell that is missing", _RECIPE),
    ("split_counts", "counts", "release", "episodes", "Episodes of a split, of those", _RECIPE),
    ("shortfalls", "counts", "release", "problems", "Shortfalls without a reason", _REBUILD),
    ("groups_apart", "splits", "release", "splits", "Splits that share a group", _REBUILD),
    ("sources_apart", "splits", "release", "splits", "Splits that share a source", _REBUILD),
    ("scenes_apart", "splits", "release", "splits", "Scene splits that share a scene", _REBUILD),
    (
        *("placements_alike", "placements", "release", "columns"),
        *("Columns that differ in a placement", _REBUILD),
    ),
    (
        *("placement_emotions", "placements", "release", "episodes"),
        *("Episodes of one emotion in a placement", _REBUILD),
    ),
    ("phase", "clips", "episode", "share", "Phase as a share of the cycle", _REBUILD),
    ("clip_length", "clips", "episode", "s", "Length of a clip of two cycles", _REBUILD),
    ("start_navigable", "navigation", "episode", "m", "Start to the largest island", _REPORT),
    ("start_clear", "navigation", "episode", "m", "Start to anybody's way", _REPORT),
    ("d_star", "navigation", "episode", "m", "Stored d* unlike the navmesh's", _REBUILD),
    ("way_clear", "bodies", "episode", "m", "Free disc around the pelvis on its way", _REPORT),
    ("body_free", "bodies", "episode", "share", "Share of the body inside things", _REPORT),
    ("seat_free", "bodies", "episode", "share", "Share of seat and thighs inside things", _REPORT),
    ("pair_place", "bodies", "episode", "m", "Partner off the place interactions are for", _REPORT),
    ("pair_apart", "bodies", "episode", "m", "Nearest the two pelvises come", _REPORT),
    ("support_named", "supports", "episode", "problems", "Seats or doors not named", _REPORT),
    ("seat_place", "supports", "episode", "m", "Sitting pelvis to the seat, on the plan", _REPORT),
    ("seat_height", "supports", "episode", "m", "Pelvis above where it rests on a seat", _REPORT),
    ("seat_facing", "supports", "episode", "deg", "Sitter's facing off the seat's", _REPORT),
    ("seat_floor", "supports", "episode", "m", "Sitter's own floor above the room's", _REPORT),
    ("seat_feet", "supports", "episode", "m", "Sitter's lowest skin above the floor", _REPORT),
    ("sit_standing", "supports", "episode", "share", "Height at first, of standing", _REPORT),
    ("sit_floor", "supports", "episode", "m", "Stand before a seat to robot's floor", _REPORT),
    ("door_closed", "supports", "episode", "deg", "Opening of the door knocked on", _REPORT),
    ("door_facing", "supports", "episode", "deg", "Facing off the way to the leaf", _REPORT),
    ("door_hand", "supports", "episode", "m", "Nearest the hand comes to the leaf", _REPORT),
    ("door_contact", "supports", "episode", "m", "Hand beside the leaf's edge", _REPORT),
    ("challenge_distance", "challenges", "episode", "m", "Start to anchor", _REPORT),
    ("challenge_visible", "challenges", "episode", "share", "Visible body share", _REPORT),
    ("challenge_bearing", "challenges", "episode", "deg", "Start off the mean facing", _REPORT),
    ("challenge_in_image", "challenges", "episode", "share", "Body in the image", _REPORT),
    ("challenge_blocked", "challenges", "episode", "share", "Straight ways free", _REPORT),
    ("challenge_detour", "challenges", "episode", "ratio", "Way over straight way", _REPORT),
    ("grounded_room", "challenges", "episode", "rooms", "Robot in another room", _REPORT),
    ("initial_distance", "cameras", "episode", "m", "Stored distance off", _REBUILD),
    ("initial_bearing", "cameras", "episode", "deg", "Stored bearing off", _REBUILD),
    ("share_init", "cameras", "episode", "share", "Stored share at p_init off", _REBUILD),
    ("share_ref", "cameras", "episode", "share", "Stored share at p_ref off", _REBUILD),
    ("share_mon", "cameras", "episode", "share", "Stored share at p_mon off", _REBUILD),
    ("clear_init", "cameras", "episode", "m", "Nearest surface to p_init", _REPORT),
    ("clear_ref", "cameras", "episode", "m", "Nearest surface to p_ref's way", _REPORT),
    ("clear_mon", "cameras", "episode", "m", "Nearest surface to p_mon", _REPORT),
    ("clear_people", "cameras", "episode", "m", "Nearest body point to a camera", _REPORT),
    ("cameras_in_rooms", "cameras", "episode", "poses", "Camera poses in no room", _REPORT),
    ("cameras_not_inside", "cameras", "episode", "poses", "Poses in closed solids", _REPORT),
    ("monitor_room", "cameras", "episode", "rooms", "Monitor in another room", _REPORT),
    ("reference_closes", "cameras", "episode", "m", "Last step beyond the others", _REPORT),
    ("trajectory_files", "trajectories", "asset", "problems", "Problems with a file", _RECORD),
    ("trajectory_episodes", "trajectories", "episode", "episodes", "Not in the split", _RECORD),
    (
        "trajectory_values",
        "trajectories",
        "episode",
        "rows",
        "Rows no robot can make",
        _RECORD,
    ),
    ("trajectory_steps", "trajectories", "episode", "rows", "Steps that do not follow", _RECORD),
    ("trajectory_times", "trajectories", "episode", "s", "time_s off the action's end", _RECORD),
    ("trajectory_phases", "trajectories", "episode", "rows", "Phases unlike the handoff", _RECORD),
    ("trajectory_clip", "trajectories", "episode", "s", "What a handoff's clip lacks", _RECORD),
    ("trajectory_start", "trajectories", "episode", "m", "First step off the start", _RECORD),
    ("trajectory_moves", "trajectories", "episode", "m", "Way beyond the action's", _RECORD),
    ("trajectory_turns", "trajectories", "episode", "deg", "Turn off the action's", _RECORD),
    ("trajectory_clipped", "trajectories", "episode", "rows", "clipped unlike the move", _RECORD),
    ("trajectory_floor", "trajectories", "episode", "m", "Robot to the navmesh", _RECORD),
    ("reference_visible", "quality", "release", "share", "Mean visible share at p_ref", _REPORT),
    ("reference_middle", "quality", "release", "share", "Frames with body in the middle", _REPORT),
    ("leakage", "quality", "release", "share", "Accuracy beyond chance", _REPORT),
)
CHECKS: dict[str, Check] = {row[0]: Check(*row) for row in _ROWS}
"""By name, in the order of the table."""
GROUPS: tuple[str, ...] = tuple(dict.fromkeys(check.group for check in CHECKS.values()))
