"""Validation: whether all that a release promises holds, measured from its own stored bytes."""

from affectsim_data.builders.validation.catalogue import CHECKS
from affectsim_data.builders.validation.findings import Check, Failure, Measure, Outcome
from affectsim_data.builders.validation.report import REPORT_SCHEMA, ValidationReport
from affectsim_data.builders.validation.validating import SAMPLE, validate_release

__all__ = [
    "CHECKS",
    "REPORT_SCHEMA",
    "SAMPLE",
    "Check",
    "Failure",
    "Measure",
    "Outcome",
    "ValidationReport",
    "validate_release",
]
