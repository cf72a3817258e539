"""What a reader of a page must know who has not read the paper."""

from __future__ import annotations

from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.tables.texts import condition_title

__all__ = ["guide"]

_VIEWS = {
    "p_init": "P-Init: what the robot sees from where it starts, standing still.",
    "p_mon": "P-Mon: a still camera near the ceiling of the person's room.",
    "a_obs": "A-Obs: what a policy that moves the robot collected.",
    "p_ref": "P-Ref: a good view chosen with knowledge of the whole scene; a reference, no oracle.",
}


def guide(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Words of the page with what they mean, as far as these results use them."""
    settings, active = evaluation.settings, "a_obs" in evaluation.conditions
    parts = [
        ("Conditions", _conditions(evaluation)),
        (
            "Macro-F1",
            "The mean over the five emotions of F1, which weighs how many episodes of an emotion "
            "are found against how many answers naming it are right. An answer that names no "
            "emotion, or several, is wrong.",
        ),
        ("Chance", _chance(evaluation)),
        (
            "Intervals",
            f"{100 * settings.confidence:g} % intervals that follow from drawing whole "
            f"{settings.cluster}s again and again ({settings.num_clusters:,} of them, a cluster "
            "bootstrap), not single episodes: episodes that replay the same "
            f"{settings.cluster} are alike, and taking them for independent would make intervals "
            "too narrow. All models and conditions are drawn together, so differences are between "
            "the same episodes. An interval of a difference "
            "that includes 0 does not show a difference; it does not show that there is none.",
        ),
        (
            "Gap",
            "Macro-F1 under P-Ref minus P-Init: what the view alone is worth, with scene, motion "
            "and recognizer unchanged.",
        ),
    ]
    if active:
        parts += [
            ("Gain", "Macro-F1 under A-Obs minus P-Init."),
            (
                "OGR, observation gap recovery",
                "Gain divided by gap: 0 is no gain, 1 reaches the reference view, more beats it, "
                "less than 0 is a loss. It is undefined unless P-Ref is above P-Init, and its "
                "interval has no bound where that of the gap reaches 0. The mean of the models' "
                "ratios is not the ratio of the means: both are given, under these names.",
            ),
            (
                "Fallback",
                "Where the policy collected no clip, A-Obs is the clip of P-Init, so both answers "
                "agree by construction. Such episodes count in every score, but are no evidence "
                "in tests. The new-observation subset leaves them out; it is an outcome of the "
                "policy, not a part of the benchmark.",
            ),
            (
                "Recovery rate, E-SPL",
                "The share of wrong answers under P-Init that are right under A-Obs; and the share "
                "of right answers under A-Obs, each weighed by shortest way over way taken, for a "
                "ring of 1, 3 or 5 m around the person.",
            ),
        ]
    if evaluation.tests:
        parts.append(
            (
                "Tests",
                "McNemar's exact test takes episodes for independent, the permutation test swaps "
                f"the conditions of whole {settings.cluster}s; trust the second. Holm: adjusted "
                "for the number of models.",
            )
        )
    return parts


def _conditions(evaluation: Evaluation) -> str:
    known = [text for name, text in _VIEWS.items() if name in evaluation.conditions]
    others = [condition_title(one) for one in evaluation.conditions if one not in _VIEWS]
    told = "Each episode is a person in a scene, seen under every condition: "
    text = told + " ".join(known) if known else told.removesuffix(": ") + "."
    return f"{text} Others: {', '.join(others)}." if others else text


def _chance(evaluation: Evaluation) -> str:
    text = (
        f"{100 * evaluation.chance:.1f} % is the Macro-F1 expected of guessing one of five "
        "emotions at random. A score whose interval reaches down to it has not been shown to be "
        "better than guessing."
    )
    constant = [one.macro_f1 for one in evaluation.references if one.name.startswith("constant")]
    if constant:
        text += (
            " Always answering the same emotion scores "
            f"{100 * min(constant):.1f} to {100 * max(constant):.1f} %, less than guessing: a "
            "score below chance often means that nearly always the same is answered."
            if round(max(constant), 3) > round(min(constant), 3)
            else f" Always answering the same emotion scores {100 * max(constant):.1f} %, less "
            "than guessing: a score below chance often means that nearly always the same is "
            "answered."
        )
    return text
