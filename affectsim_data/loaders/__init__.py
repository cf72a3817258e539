"""Datasets: episodes of a release as typed, collatable samples, in an order one can resume."""

from affectsim_data.loaders.batches import EpisodeBatches, ResumeToken
from affectsim_data.loaders.concatenation import ConcatenatedDataset, concatenate
from affectsim_data.loaders.dataset import AffectSimDataset
from affectsim_data.loaders.loading import EpisodeLoader, data_loader
from affectsim_data.loaders.presets import Clip, condition_names, resolve_clip, resolve_condition
from affectsim_data.loaders.samples import Sample, clip_spec, draw_sample
from affectsim_data.loaders.streams import EpisodeStream

__all__ = [
    "AffectSimDataset",
    "Clip",
    "ConcatenatedDataset",
    "EpisodeBatches",
    "EpisodeLoader",
    "EpisodeStream",
    "ResumeToken",
    "Sample",
    "clip_spec",
    "concatenate",
    "condition_names",
    "data_loader",
    "draw_sample",
    "resolve_clip",
    "resolve_condition",
]
