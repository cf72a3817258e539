"""The paper's own results, as printed, to be quoted beside others.

Source: the AffectSim report (2026), Tables 3 to 6 and the captions of Tables 4 and 5. They were
measured on other scenes, motions and bodies than those of our releases: quote, do not compare.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Literal

from affectsim_data.evaluation.metrics import observation_gap_recovery
from affectsim_data.evaluation.scored import RINGS_M

__all__ = [
    "PUBLISHED",
    "PUBLISHED_EXECUTION",
    "PUBLISHED_SUBSETS",
    "PUBLISHED_VALID_RINGS",
    "PublishedExecution",
    "PublishedMean",
    "PublishedRow",
    "PublishedSubset",
    "published_means",
]

Access = Literal["open", "closed"]
"""Whether the weights of a model are to be had."""


@dataclasses.dataclass(frozen=True)
class PublishedRow:
    """A model in Tables 3 and 5; numbers are percent, with the two decimals that were printed."""

    group: str
    """As the tables are divided."""
    access: Access
    """What the paper's means are over."""
    model: str
    parameters: str
    """Size; empty where it is not known."""
    macro_f1: Mapping[str, float]
    """By condition: p_mon, p_ref, p_init, a_obs."""
    gain: float
    """Under a_obs minus p_init, percentage points."""
    recovery_rate: float
    e_spl: Mapping[int, float]
    """By ring, metres."""

    @property
    def ogr(self) -> float:
        """Observation gap recovery, a share; NaN unless p_ref is above p_init."""
        return _ogr(self.macro_f1)


@dataclasses.dataclass(frozen=True)
class PublishedMean:
    """Unweighted means over models, computed from the rows; percent, and shares for OGR.

    All means the paper prints follow to the last digit. Its OGR, 32.0 % and 20.1 %, is that of the
    means before they are rounded; from the printed means it would be 31.9 % and 20.2 %, and the
    mean of the models' own OGR is another number.
    """

    name: str
    """As the paper says it, `Open-source mean (19)`."""
    num_models: int
    macro_f1: Mapping[str, float]
    gain: float
    ogr_of_means: float
    mean_ogr: float
    """Over the models with p_ref above p_init."""
    num_ogr: int
    recovery_rate: float
    e_spl: Mapping[int, float]


@dataclasses.dataclass(frozen=True)
class PublishedSubset:
    """A row of Table 4: mean Macro-F1 of a group of models on a subset, percent."""

    access: Access
    subset: Literal["all", "new_observation"]
    num_episodes: int
    p_init: float
    a_obs: float
    gain: float


@dataclasses.dataclass(frozen=True)
class PublishedExecution:
    """Table 6: how the paper's policy behaved on the test split."""

    num_episodes: int
    stable_handoff: float
    """Percent of episodes."""
    mean_path_m: float
    path_before_handoff: float
    """Percent of locomotion."""
    budget_exhausted: float
    """Percent of episodes."""
    clipped: float
    """Percent of attempted translations."""


PUBLISHED_SUBSETS = (
    PublishedSubset("open", "all", 3941, 9.89, 11.70, 1.81),
    PublishedSubset("open", "new_observation", 1881, 10.95, 14.35, 3.40),
    PublishedSubset("closed", "all", 3941, 22.61, 24.26, 1.64),
    PublishedSubset("closed", "new_observation", 1881, 25.38, 28.29, 2.91),
)
PUBLISHED_EXECUTION = PublishedExecution(3941, 47.73, 23.23, 97.4, 52.27, 14.10)
PUBLISHED_VALID_RINGS = {1: 3811, 3: 3887, 5: 3859}
"""Episodes that E-SPL is over, by ring."""

_GROUPS: dict[str, tuple[str, Access]] = {
    "general": ("Open-source general-purpose", "open"),
    "emotion": ("Open-source emotion-recognition", "open"),
    "closed": ("Closed-source general-purpose", "closed"),
}
_CONDITIONS = ("p_mon", "p_ref", "p_init", "a_obs")
_ROWS = """
general | InternVL2.5                  | 4B  |  9.92 20.60 10.04 12.81  2.77  3.24  1.33  0.68  0.70
general | InternVL2.5                  | 8B  | 11.36 21.90 10.88 13.51  2.63  2.92  1.29  0.67  0.60
general | InternVL2.5 INT8             | 38B | 11.39 19.97 10.74 13.22  2.48  2.98  1.23  0.62  0.63
general | InternVL2.5                  | 78B | 20.70 30.02 17.24 18.52  1.28  4.05  1.74  1.01  0.67
general | Qwen2.5-VL                   | 7B  |  5.99  6.12  6.09  6.11  0.02  0.24  0.13  0.08  0.09
general | Qwen2.5-VL INT8              | 32B |  5.92  6.21  6.12  6.06 -0.06  0.15  0.05  0.02  0.03
general | Qwen2.5-VL BF16              | 72B |  6.63  7.57  6.53  7.63  1.10  1.16  0.58  0.29  0.31
general | Qwen2.5-Omni visual-only     | 7B  |  7.78 12.09  7.78  9.45  1.67  1.73  0.71  0.37  0.34
general | Qwen3-VL-Instruct            | 8B  | 11.79 15.54 10.12 13.19  3.07  5.74  2.68  1.49  1.28
general | Qwen3-VL-Thinking-40960      | 8B  |  8.68 11.15  7.93  9.59  1.66  2.22  1.11  0.65  0.49
general | VideoLLaMA2                  | 7B  |  7.47 12.69  7.08 10.23  3.15  2.77  1.24  0.65  0.71
general | VideoLLaMA2                  | 72B | 10.25 19.05  9.80 14.08  4.28  4.68  2.00  0.99  0.95
general | VideoLLaMA2.1-16F            | 7B  |  7.97 16.25  8.73 11.20  2.47  2.59  1.13  0.53  0.62
general | VideoLLaMA2.1-AV visual-only | 7B  | 20.27 27.65 18.67 20.89  2.22  7.76  3.43  1.90  1.54
general | InternVideo2-Chat            | 8B  |  7.04  9.98  7.04  8.07  1.03  1.17  0.51  0.25  0.31
general | LongVA-DPO                   | 7B  |  8.95 13.57  7.55 10.80  3.25  3.50  1.65  0.99  0.89
general | MiniCPM-V2.6                 | 8B  |  6.34  9.89  6.55  6.79  0.24  0.79  0.42  0.29  0.24
emotion | AffectGPT-frame              | 7B  | 11.63 10.11 11.79 11.13 -0.66  3.31  1.32  0.63  0.74
emotion | Emotion-LLaMA                | 7B  | 15.89 25.29 17.16 19.04  1.88  7.88  3.03  1.75  1.43
closed  | Gemini-3.0-Flash             |     | 25.11 28.33 24.77 24.62 -0.15  6.08  2.37  1.39  0.97
closed  | Gemini-3.0-Pro               |     | 25.21 30.21 22.66 25.42  2.76  9.11  3.93  2.34  1.52
closed  | GPT-5.2                      |     | 21.08 28.20 20.89 21.00  0.11  4.23  1.75  1.05  0.78
closed  | GPT-5.6-sol                  |     | 21.53 31.48 19.29 21.87  2.58  5.51  2.27  1.41  0.86
closed  | Claude Opus 5                |     | 29.27 35.68 25.46 28.37  2.91 11.27  4.83  2.66  2.03
"""
"""Group, model, parameters; p_mon, p_ref, p_init, a_obs, gain; recovery rate, E-SPL@1, 3, 5."""


def _row(line: str) -> PublishedRow:
    group, model, parameters, written = (part.strip() for part in line.split("|"))
    numbers = [float(number) for number in written.split()]
    title, access = _GROUPS[group]
    return PublishedRow(
        group=title,
        access=access,
        model=model,
        parameters=parameters,
        macro_f1=dict(zip(_CONDITIONS, numbers[:4], strict=True)),
        gain=numbers[4],
        recovery_rate=numbers[5],
        e_spl=dict(zip(RINGS_M, numbers[6:], strict=True)),
    )


PUBLISHED = tuple(_row(line) for line in _ROWS.strip().splitlines())
"""The 24 models, in the order of the tables."""


def published_means() -> tuple[PublishedMean, ...]:
    """Means over the 19 open-source models, the 5 closed-source ones, and all 24."""
    opened = [row for row in PUBLISHED if row.access == "open"]
    closed = [row for row in PUBLISHED if row.access == "closed"]
    return (
        _mean(f"Open-source mean ({len(opened)})", opened),
        _mean(f"Closed-source mean ({len(closed)})", closed),
        _mean(f"Mean of all ({len(PUBLISHED)})", PUBLISHED),
    )


def _mean(name: str, rows: Sequence[PublishedRow]) -> PublishedMean:
    macro_f1 = {one: _average([row.macro_f1[one] for row in rows]) for one in _CONDITIONS}
    own = [row.ogr for row in rows if not math.isnan(row.ogr)]
    return PublishedMean(
        name=name,
        num_models=len(rows),
        macro_f1=macro_f1,
        gain=_average([row.gain for row in rows]),
        ogr_of_means=_ogr(macro_f1),
        mean_ogr=_average(own),
        num_ogr=len(own),
        recovery_rate=_average([row.recovery_rate for row in rows]),
        e_spl={ring: _average([row.e_spl[ring] for row in rows]) for ring in RINGS_M},
    )


def _average(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


def _ogr(macro_f1: Mapping[str, float]) -> float:
    return observation_gap_recovery(
        initial=macro_f1["p_init"], reference=macro_f1["p_ref"], active=macro_f1["a_obs"]
    )
