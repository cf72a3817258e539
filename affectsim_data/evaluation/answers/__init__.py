"""Raw model text in, one of the five emotions or an outcome out; rules, no language model."""

from affectsim_data.evaluation.answers.answer import Answer
from affectsim_data.evaluation.answers.parsing import audit_answers, parse_answer, parse_answers

__all__ = ["Answer", "audit_answers", "parse_answer", "parse_answers"]
