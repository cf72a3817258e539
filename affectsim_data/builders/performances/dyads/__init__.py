"""Interactions of two people, aligned in time and space, three for each emotion of the target.

Each is two scripts on one time line (`interaction`), played by two performers and brought together:
palms meet, hands touch and faces turn to each other (`meeting`). Reactions come a quarter to half
a second late, as people's do.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.performances.curves import cycle_phase
from affectsim_data.builders.performances.dyads import (
    accuse,
    argue,
    bad_news,
    celebrate,
    chat,
    cling,
    comfort,
    cower,
    directions,
    dismiss,
    farewell,
    greet,
    hand_over,
    joke,
    startle,
)
from affectsim_data.builders.performances.dyads.interaction import Interaction
from affectsim_data.builders.performances.dyads.meeting import Actor, meet
from affectsim_data.builders.performances.rig import SIGN, BodyTrack
from affectsim_data.builders.performances.scenarios.staging import stage_script
from affectsim_data.builders.performances.styles import Performer, Side
from affectsim_data.builders.performances.walking import FPS
from affectsim_data.motions.motion import EMOTIONS, Emotion
from affectsim_data.poses import FloatArray, compose_pose, quaternion_rotate, yaw_quaternion

__all__ = ["DYADS", "NUM_DYADS", "DyadTracks", "dyad_tracks", "interaction_of"]

NUM_DYADS = 3
"""Interactions of each emotion."""
_INTERACTIONS: dict[Emotion, tuple[Interaction, Interaction, Interaction]] = {
    "angry": (argue.INTERACTION, accuse.INTERACTION, dismiss.INTERACTION),
    "fearful": (startle.INTERACTION, cower.INTERACTION, cling.INTERACTION),
    "happy": (celebrate.INTERACTION, greet.INTERACTION, joke.INTERACTION),
    "neutral": (chat.INTERACTION, directions.INTERACTION, hand_over.INTERACTION),
    "sad": (comfort.INTERACTION, farewell.INTERACTION, bad_news.INTERACTION),
}
DYADS: dict[Emotion, tuple[str, str, str]] = {
    emotion: (one.name, two.name, three.name)
    for emotion, (one, two, three) in _INTERACTIONS.items()
}
"""Names of the interactions; `take` is the place in the row."""
_SHORTEST_S, _LONGEST_S = 5.0, 10.0
_MOST = 1.4
"""Greatest intensity: steps grow with it, and two people share little room."""


@dataclasses.dataclass(frozen=True)
class DyadTracks:
    """Two people in one interaction; both tracks have the same number of frames."""

    name: str
    """What they do: `argue`, `comfort`, ..."""
    target: BodyTrack
    """Whose emotion counts."""
    partner: BodyTrack
    """The other, in an own frame."""
    T_target_partner: FloatArray
    """The partner's frame in the target's, `(4, 4)`."""
    partner_emotion: Emotion
    """What the partner shows."""


def dyad_tracks(
    emotion: Emotion,
    take: int,
    first: Performer,
    second: Performer,
    *,
    intensity: float,
    rng: np.random.Generator,
) -> DyadTracks:
    """An interaction played by two performers, one closed cycle of 5 to 10 s at 30 fps.

    Args:
        emotion: What the target feels.
        take: Which of the emotion's three interactions, see `DYADS`.
        first: The target.
        second: The partner.
        intensity: How strongly both show what they feel; 1 is the full style, 0 a plain version.
        rng: Noise of this take.

    Raises:
        ValueError: No such emotion or take.
    """
    interaction = interaction_of(emotion, take)
    first = first.feeling(emotion)
    second = second.feeling(interaction.partner_emotion)
    hands = _hands(interaction, first, second)
    intensity = float(np.clip(intensity, 0.0, _MOST))
    script = interaction.target.script
    length_s = script.plain_s + intensity * (script.duration_s - script.plain_s)
    length_s /= 0.5 * (first.tempo + second.tempo)
    frames = round(np.clip(length_s, _SHORTEST_S, _LONGEST_S) * FPS)
    tracks = [
        stage_script(
            role.script,
            feels,
            dataclasses.replace(who, hand=hand),
            intensity=intensity,
            rng=rng,
            num_frames=frames,
        )
        for role, feels, who, hand in (
            (interaction.target, emotion, first, hands[0]),
            (interaction.partner, interaction.partner_emotion, second, hands[1]),
        )
    ]
    sign = SIGN[hands[0]]
    target = Actor(tracks[0], hands[0])
    partner = Actor(
        tracks[1],
        hands[1],
        x=sign * interaction.side_m,
        z=interaction.forward_m,
        yaw=sign * np.deg2rad(interaction.facing_deg),
    )
    meet(interaction, target, partner, cycle_phase(frames))
    return _from_first_pelvis(interaction, target, partner)


def interaction_of(emotion: Emotion, take: int) -> Interaction:
    """What is done in a take of an emotion.

    Raises:
        ValueError: No such emotion or take.
    """
    if emotion not in _INTERACTIONS:
        raise ValueError(f"emotion must be one of {', '.join(EMOTIONS)}, got {emotion!r}")
    if not 0 <= take < NUM_DYADS:
        known = ", ".join(f"{place} ({name})" for place, name in enumerate(DYADS[emotion]))
        raise ValueError(f"interaction {emotion!r}: take must be one of {known}, got {take}")
    return _INTERACTIONS[emotion][take]


def _hands(interaction: Interaction, first: Performer, second: Performer) -> tuple[Side, Side]:
    """Which hand each of the two prefers in this interaction."""
    if interaction.hands == "right":
        return "right", "right"
    if interaction.hands == "same":
        return first.hand, first.hand
    if interaction.hands == "mirrored":
        return first.hand, first.other_hand
    return first.hand, second.hand


def _from_first_pelvis(interaction: Interaction, target: Actor, partner: Actor) -> DyadTracks:
    """Both frames moved to the floor under the pelvis of frame 0."""
    shifts = [actor.track.pelvis_position[0] * [1.0, 0.0, 1.0] for actor in (target, partner)]
    turn = yaw_quaternion(partner.yaw)
    place = np.array([partner.x, 0.0, partner.z]) + quaternion_rotate(turn, shifts[1]) - shifts[0]
    for actor, shift in zip((target, partner), shifts, strict=True):
        track = actor.track
        track.pelvis_position = track.pelvis_position - shift
        for ankles in track.ankles.values():
            ankles -= shift
        for contact in track.contacts.values():
            contact.position = contact.position - shift
    return DyadTracks(
        interaction.name,
        target.track,
        partner.track,
        compose_pose(turn, place),
        interaction.partner_emotion,
    )
