"""Measurements behind every claim in docs/performance.md; `make bench` runs them all."""
