"""Looking at releases: contact sheets, Rerun recordings, and what this machine can draw."""

from affectsim_data.inspection.contact_sheet import contact_sheet, representative_episodes
from affectsim_data.inspection.doctor import examine
from affectsim_data.inspection.recording import record_episode
from affectsim_data.inspection.summary import release_summary
from affectsim_data.inspection.views import SHOWN_CONDITIONS, condition_title, draw_views

__all__ = [
    "SHOWN_CONDITIONS",
    "condition_title",
    "contact_sheet",
    "draw_views",
    "examine",
    "record_episode",
    "release_summary",
    "representative_episodes",
]
