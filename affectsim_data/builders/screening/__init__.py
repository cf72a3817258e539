"""Screening: which motions are broken, where, and why."""

from affectsim_data.builders.screening.findings import Finding
from affectsim_data.builders.screening.report import REPORT_SCHEMA, ScreenReport
from affectsim_data.builders.screening.screen import screen_motion, screen_outliers
from affectsim_data.builders.screening.tempo_checks import Jerkiness, jerkiness
from affectsim_data.builders.screening.thresholds import Thresholds, load_thresholds

__all__ = [
    "REPORT_SCHEMA",
    "Finding",
    "Jerkiness",
    "ScreenReport",
    "Thresholds",
    "jerkiness",
    "load_thresholds",
    "screen_motion",
    "screen_outliers",
]
