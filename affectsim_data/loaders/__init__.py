"""Datasets: episodes of a release as typed, collatable samples."""

from affectsim_data.loaders.dataset import AffectSimDataset, data_loader
from affectsim_data.loaders.presets import Clip, condition_names, resolve_clip, resolve_condition
from affectsim_data.loaders.samples import Sample, clip_spec, draw_sample

__all__ = [
    "AffectSimDataset",
    "Clip",
    "Sample",
    "clip_spec",
    "condition_names",
    "data_loader",
    "draw_sample",
    "resolve_clip",
    "resolve_condition",
]
