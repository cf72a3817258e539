"""Predictions in, numbers out: parsing of answers, metrics, statistics."""

from affectsim_data.evaluation.results import Estimate, Evaluation
from affectsim_data.evaluation.scored import ScoredTable

__all__ = ["Estimate", "Evaluation", "ScoredTable"]
