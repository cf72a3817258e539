"""Whether the emotion can be told without looking: classifiers on the metadata of episodes alone.

An episode is a motion, a place and a camera. The label comes with the motion, so these columns may
follow the emotion: motion, group and performance ids, duration, phase in seconds, the reference
view with its score, the visible shares and the bearing to the performer's mean heading. All others
are chosen once for every emotion of a matched set and may not: `PLACEMENT_COLUMNS` are equal in all
episodes of a placement, and neither they, nor the phase's share of the cycle, nor the order of the
episodes may tell a classifier more than chance.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["PLACEMENT_COLUMNS", "Probe", "leakage_probe"]

PLACEMENT_COLUMNS = (
    *("split", "scene_split", "family", "challenge", "action", "scene_id", "support"),
    *("performer_id", "avatar_id", "partner_performer_id", "partner_avatar_id", "target"),
    *(f"{what}_{axis}_m" for what in ("anchor", "partner_anchor", "start") for axis in "xyz"),
    *("facing_deg", "partner_facing_deg", "start_yaw_deg", "initial_distance_m"),
    *(f"monitor_{axis}_m" for axis in "xyz"),
    *("monitor_yaw_deg", "monitor_pitch_deg"),
    *(f"d_star_{ring}m{end}" for ring in (1, 3, 5) for end in ("", "_null")),
)
"""What all episodes of a placement share."""
_NAMED = ("scene_id", "family", "challenge", "action", "support", "avatar_id", "partner_avatar_id")
_NUMBERS = (
    *(f"{what}_{axis}_m" for what in ("anchor", "start", "monitor") for axis in "xyz"),
    *("initial_distance_m", "monitor_pitch_deg"),
)
_ANGLES = ("facing_deg", "start_yaw_deg", "monitor_yaw_deg")
Features = Literal["placement", "placement and reference"]


@dataclasses.dataclass(frozen=True)
class Probe:
    """How well one classifier tells the emotion in splits it was not trained on."""

    classifier: str
    """`logistic regression` or `random forest`."""
    features: Features
    """`placement`: scene, anchor, start, challenge, bodies, monitor, phase, number; the other adds
    where the reference camera is."""
    accuracy: float
    """Mean share of right answers over the emotions, so that frequent ones count no more."""
    chance: float
    """The same of a guess: one by the number of emotions."""
    standard_error: float
    """Of the accuracy of a guess, from the number of episodes."""
    num_train: int
    """Episodes of the train split."""
    num_tested: int
    """Episodes of all other splits."""

    @property
    def excess(self) -> float:
        """Accuracy above chance; near 0 where nothing leaks."""
        return self.accuracy - self.chance


def leakage_probe(table: pa.Table, *, seed: int = 0) -> dict[str, Probe]:
    """Trains classifiers on the metadata of the train split and tests them on the other splits.

    The random forest finds any dependence on a few columns, the logistic regression weak ones
    spread over many. About 3,000 tested episodes bring the standard error down to 0.7 points.

    Args:
        table: Rows of the episodes table, all splits.
        seed: Of the classifiers.

    Returns:
        Probes by `"FEATURES: CLASSIFIER"`.

    Raises:
        ValueError: There is only one emotion, or no episode in train or outside it.
    """
    labels = np.array(table.column("emotion").to_pylist())
    training = np.array(table.column("split").to_pylist()) == "train"
    emotions = [one for one in EMOTIONS if (labels[training] == one).any()]
    if training.all() or not training.any() or len(emotions) < 2:
        raise ValueError(
            "a leakage probe needs episodes of two emotions in train, and others to test on; "
            f"got {int(training.sum())} of {len(labels)} in train, of {len(emotions)} emotions"
        )
    tested = ~training & np.isin(labels, emotions)
    counts = np.array([(labels[tested] == one).sum() for one in emotions])
    counts = counts[counts > 0]
    chance = 1.0 / len(emotions)
    error = math.sqrt(chance * (1.0 - chance) * float((1.0 / counts).sum())) / len(counts)
    probes: dict[str, Probe] = {}
    views: tuple[tuple[Features, FloatArray], ...] = (
        ("placement", _placement_features(table)),
        ("placement and reference", np.hstack([_placement_features(table), _reference(table)])),
    )
    for features, values in views:
        for name, make in _classifiers().items():
            model = make(seed).fit(values[training], labels[training])
            right = model.predict(values[tested]) == labels[tested]
            recalls = [right[labels[tested] == one] for one in emotions]
            accuracy = float(np.mean([hits.mean() for hits in recalls if len(hits)]))
            probes[f"{features}: {name}"] = Probe(
                name, features, accuracy, chance, error, int(training.sum()), int(tested.sum())
            )
    return probes


def _classifiers() -> dict[str, Callable[[int], Any]]:
    """Makers of untrained classifiers, by name; each takes its seed."""
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    return {
        "logistic regression": lambda seed: make_pipeline(
            StandardScaler(), LogisticRegression(C=0.1, max_iter=300, random_state=seed)
        ),
        "random forest": lambda seed: RandomForestClassifier(
            n_estimators=100, min_samples_leaf=3, random_state=seed
        ),
    }


def _placement_features(table: pa.Table) -> FloatArray:
    """What a cheat could use, `(num_episodes, num_features)`."""
    named = [_codes(table, name) for name in _NAMED]
    one_hot = [np.eye(int(codes.max()) + 1)[codes] for codes in named]
    numbers = [_floats(table, name)[:, None] for name in _NUMBERS]
    phase = _floats(table, "phase_s") / _floats(table, "duration_s")
    # Ids end in a number: the order in which episodes are read.
    number = np.array([one.rpartition("-")[2] for one in table.column("episode_id").to_pylist()])
    order = np.unique(number, return_inverse=True)[1]
    turns = [_turn(table, name) for name in _ANGLES]
    return np.hstack([*one_hot, *numbers, *turns, phase[:, None], order[:, None]])


def _reference(table: pa.Table) -> FloatArray:
    """Where the reference camera is to the performer, `(num_episodes, 4)`."""
    names = ("reference_distance_m", "reference_height_m")
    numbers = [_floats(table, name)[:, None] for name in names]
    return np.hstack([_turn(table, "reference_azimuth_deg"), *numbers])


def _turn(table: pa.Table, name: str) -> FloatArray:
    angles = np.radians(_floats(table, name))
    return np.stack([np.sin(angles), np.cos(angles)], axis=1)


def _floats(table: pa.Table, name: str) -> FloatArray:
    values: FloatArray = table.column(name).to_numpy().astype(np.float64)
    return values


def _codes(table: pa.Table, name: str) -> np.ndarray:
    """A number for every different value of a column, null included, `(num_episodes,)`."""
    encoded = pc.dictionary_encode(table.column(name), null_encoding="encode")
    codes: np.ndarray = encoded.combine_chunks().indices.to_numpy().astype(np.intp)
    return codes
