"""Recognizers of emotion: clips in, prediction tables out."""

from affectsim_data.recognizers.opening import open_recognizer, recognizer_kinds
from affectsim_data.recognizers.protocol import Recognizer, Reply
from affectsim_data.recognizers.running import PredictionRun, predict

__all__ = [
    "PredictionRun",
    "Recognizer",
    "Reply",
    "open_recognizer",
    "predict",
    "recognizer_kinds",
]
