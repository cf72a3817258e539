"""Recognizers behind OpenAI-compatible vision endpoints."""

from affectsim_data.recognizers.endpoint.costs import (
    CostEstimate,
    ImageRule,
    Prices,
    Probe,
    estimate_cost,
    image_tokens,
)
from affectsim_data.recognizers.endpoint.failures import EndpointStoppedError
from affectsim_data.recognizers.endpoint.recognizer import EndpointRecognizer
from affectsim_data.recognizers.endpoint.retrying import RetryPolicy
from affectsim_data.recognizers.endpoint.tallies import Usage

__all__ = [
    "CostEstimate",
    "EndpointRecognizer",
    "EndpointStoppedError",
    "ImageRule",
    "Prices",
    "Probe",
    "RetryPolicy",
    "Usage",
    "estimate_cost",
    "image_tokens",
]
