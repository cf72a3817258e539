"""Recognizers of emotion: clips in, prediction tables out."""

from affectsim_data.recognizers.protocol import Recognizer, Reply

__all__ = ["Recognizer", "Reply"]
