"""Prediction and trajectory tables: read strictly, joined with a release, written."""

from affectsim_data.evaluation.tables.joining import score_predictions
from affectsim_data.evaluation.tables.predictions import Predictions, read_predictions
from affectsim_data.evaluation.tables.problems import Places, TableProblems
from affectsim_data.evaluation.tables.trajectories import Trajectories, read_trajectories
from affectsim_data.evaluation.tables.writing import write_predictions, write_trajectories

__all__ = [
    "Places",
    "Predictions",
    "TableProblems",
    "Trajectories",
    "read_predictions",
    "read_trajectories",
    "score_predictions",
    "write_predictions",
    "write_trajectories",
]
