"""Replayable affective episodes whose observation is an experimental variable."""

__version__ = "0.1.0"
