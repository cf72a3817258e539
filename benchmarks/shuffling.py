"""What scene-aware shuffling costs in randomness, and what that does to a training run.

Orders of the train split of the wide release, nothing drawn: how alike neighbours in the order are,
and how a linear classifier learns whose features carry an offset of their scene.

python -m benchmarks.shuffling randomness | training
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.loaders.order import epoch_order, scene_aware
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release, open_release
from affectsim_data.schemas import Split
from benchmarks.parts import Rows, serve_part
from benchmarks.wide import wide_release_path

__all__ = ["PARTS", "WINDOWS", "Episodes", "order_name"]

WINDOWS = (1, 256, 1024, 4096)
"""Of the scene-aware order; a window of one episode is the plain order."""
_BATCHES = (16, 64)
_EPOCHS = 5
_SEEDS = 16
_FEATURES = 32
_SEPARATION = 2.0
"""Length of the mean of an emotion's features; their noise has variance 1 in every direction."""
_OFFSETS = (0.0, 0.5, 1.0)
"""Standard deviation of a scene's offset in every direction."""
_LEARNING_RATE = 0.1
_BATCH = 16

IntArray = NDArray[np.int64]


@dataclasses.dataclass(frozen=True)
class Episodes:
    """What of a split's episodes matters here."""

    scenes: IntArray
    """Code of each episode's scene, `(n,)`."""
    emotions: IntArray
    """Label of each episode, `(n,)`."""

    @classmethod
    def of(cls, release: Release, split: Split) -> Episodes:
        """Those of a split, in the order of its table."""
        index = release.episode_index(split)
        scenes = np.unique(index.column("scene_id").to_pylist(), return_inverse=True)[1]
        labels = [EMOTIONS.index(emotion) for emotion in index.column("emotion").to_pylist()]
        return cls(scenes.astype(np.int64), np.array(labels))

    def order(self, window: int, epoch: int) -> tuple[IntArray, IntArray]:
        """The plain order of an epoch, and the scene-aware one made from it, `(n,)` each."""
        plain = epoch_order(len(self.scenes), seed=0, epoch=epoch, fingerprint="00")
        return plain, scene_aware(plain, self.scenes, window=window)


def randomness() -> Rows:
    """How alike the episodes of a batch are, per window; means over epochs."""
    episodes = Episodes.of(open_release(wide_release_path()), "train")
    rows = []
    for window in WINDOWS:
        epochs = [_randomness(episodes, *episodes.order(window, e)) for e in range(_EPOCHS)]
        means = {name: float(np.mean([one[name] for one in epochs])) for name in epochs[0]}
        rows.append({"order": order_name(window), **means})
    return rows


def order_name(window: int) -> str:
    """What tables call the order of a window."""
    return "plain" if window == 1 else f"scenes, window {window}"


def _randomness(episodes: Episodes, plain: IntArray, order: IntArray) -> dict[str, float]:
    scenes, emotions = episodes.scenes[order], episodes.emotions[order]
    share = np.bincount(emotions, minlength=len(EMOTIONS)) / len(emotions)
    row = {f"scenes_per_batch_of_{size}": _mean_distinct(scenes, size) for size in _BATCHES}
    row |= {f"emotion_distance_{size}": _mix_distance(emotions, size, share) for size in _BATCHES}
    row["next_from_same_scene"] = float(np.mean(scenes[1:] == scenes[:-1]))
    row["mean_displacement"] = float(np.mean(np.abs(np.argsort(order) - np.argsort(plain))))
    return row


def _batches(values: IntArray, size: int) -> IntArray:
    """Whole batches, `(num_batches, size)`."""
    return values[: len(values) // size * size].reshape(-1, size)


def _mean_distinct(values: IntArray, size: int) -> float:
    rows = np.sort(_batches(values, size), axis=1)
    return float(np.mean(1 + np.count_nonzero(np.diff(rows, axis=1), axis=1)))


def _mix_distance(emotions: IntArray, size: int, share: FloatArray) -> float:
    """Total variation between a batch's mix of emotions and the split's, mean over batches."""
    counts = (_batches(emotions, size)[..., None] == np.arange(len(share))).sum(axis=1)
    return float(np.mean(np.abs(counts / size - share).sum(axis=1) / 2.0))


def training() -> Rows:
    """A linear classifier after one epoch in every order, and how noisy its gradients are."""
    release = open_release(wide_release_path())
    train, test = Episodes.of(release, "train"), Episodes.of(release, "test")
    rows = []
    for offset in _OFFSETS:
        runs = [_train_all(train, test, offset, seed) for seed in range(_SEEDS)]
        for place, window in enumerate(WINDOWS):
            accuracy = 100.0 * np.array([run[place]["accuracy"] for run in runs])
            change = accuracy - 100.0 * np.array([run[0]["accuracy"] for run in runs])
            variance = np.array([run[place]["variance"] / run[0]["variance"] for run in runs])
            rows.append(
                {
                    "scene_offset": offset,
                    "order": order_name(window),
                    "gradient_variance_over_plain": float(variance.mean()),
                    "accuracy_percent": float(accuracy.mean()),
                    "change_in_points": float(change.mean()),
                    "its_standard_error": float(change.std(ddof=1) / np.sqrt(len(change))),
                }
            )
    return rows


def _train_all(train: Episodes, test: Episodes, offset: float, seed: int) -> list[dict[str, Any]]:
    """Outcome per window on one draw of features, all from the same start."""
    rng = np.random.default_rng(seed)
    means = rng.normal(size=(len(EMOTIONS), _FEATURES))
    means *= _SEPARATION / np.linalg.norm(means, axis=1, keepdims=True)
    offsets = offset * rng.normal(size=(int(train.scenes.max()) + 1, _FEATURES))
    seen, unseen = (
        means[one.emotions] + offsets[one.scenes] + rng.normal(size=(len(one.scenes), _FEATURES))
        for one in (train, test)
    )
    orders = [train.order(window, seed)[1] for window in WINDOWS]
    # Gradients are compared at the same weights: those half-way through the plain epoch.
    middle = _descend(seen, train.emotions, orders[0][: len(orders[0]) // 2])
    outcomes = []
    for order in orders:
        weights = _descend(seen, train.emotions, order)
        hits = (unseen @ weights).argmax(axis=1) == test.emotions
        variance = _gradient_variance(seen, train.emotions, order, middle)
        outcomes.append({"accuracy": float(hits.mean()), "variance": variance})
    return outcomes


def _descend(features: FloatArray, labels: IntArray, order: IntArray) -> FloatArray:
    """Weights after one pass of stochastic gradient descent, `(num_features, num_emotions)`."""
    weights = np.zeros((features.shape[1], len(EMOTIONS)))
    for batch in _batches(order, _BATCH):
        weights -= _LEARNING_RATE * _gradient(features[batch], labels[batch], weights)
    return weights


def _gradient(features: FloatArray, labels: IntArray, weights: FloatArray) -> FloatArray:
    """Of the mean cross-entropy, `(num_features, num_emotions)`."""
    scores = features @ weights
    errors = np.exp(scores - scores.max(axis=1, keepdims=True))
    errors /= errors.sum(axis=1, keepdims=True)
    errors[np.arange(len(labels)), labels] -= 1.0
    gradient: FloatArray = features.T @ errors / len(labels)
    return gradient


def _gradient_variance(
    features: FloatArray, labels: IntArray, order: IntArray, weights: FloatArray
) -> float:
    """Mean squared distance of a batch's gradient from the mean of all."""
    gradients = np.stack(
        [_gradient(features[b], labels[b], weights) for b in _batches(order, _BATCH)]
    )
    return float(np.mean(np.sum((gradients - gradients.mean(axis=0)) ** 2, axis=(1, 2))))


PARTS = {"randomness": randomness, "training": training}

if __name__ == "__main__":
    serve_part(PARTS)
