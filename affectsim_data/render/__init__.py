"""Rendering: the only place that opens EGL."""
