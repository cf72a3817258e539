"""Words an answer may use: what stands for an emotion, and what stands for none of the five."""

from __future__ import annotations

from typing import Literal

from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.motion import Emotion

__all__ = [
    "EMOJI",
    "EMOTION_WORDS",
    "NEAR_WORDS",
    "OUTSIDE_WORDS",
    "Meaning",
    "decisions_table",
    "meaning_of",
    "words_table",
]

Meaning = Literal["angry", "fearful", "happy", "neutral", "sad", "outside", "near"]
"""An emotion; another emotion than the five; a word near one of them that decides nothing."""

EMOTION_WORDS: dict[Emotion, str] = {
    "angry": "angry angrily angrier angriest anger angers angered mad furious furiously fury rage "
    "raging enraged irate livid outraged outrage infuriated incensed wrath wrathful",
    "fearful": "fearful fearfully fearfulness fear fears fearing feared afraid scared frightened "
    "fright frightful terrified terror petrified panic panicked panicky panicking horrified horror "
    "dread spooked",
    "happy": "happy happily happier happiest happiness joy joyful joyfully joyfulness joyous "
    "joyously cheerful cheerfully cheerfulness glad gladness gleeful glee delighted delight elated "
    "elation jubilant jubilation overjoyed ecstatic merry euphoric euphoria",
    "neutral": "neutral neutrally neutrality emotionless expressionless impassive unemotional",
    "sad": "sad sadly sadder saddest sadness saddened sorrow sorrowful sorrowfully unhappy "
    "unhappily unhappiness grief grieving mournful mourning dejected dejection despondent "
    "miserable misery heartbroken melancholy melancholic downhearted woeful",
}
"""Label words with their inflections, then synonyms; lower case."""

OUTSIDE_WORDS: dict[str, str] = {
    "surprised surprise surprising astonished astonishment amazed amazement shocked startled": (
        "surprise (KDAE) has no valence of its own"
    ),
    "disgusted disgust disgusting revulsion": "disgust (KDAE) is near none of the five",
    "contempt contemptuous disdain": "contempt is neither anger nor disgust",
    "anxious anxiety anxiously": "anxiety (Emilya) is milder and longer than fear",
    "proud pride proudly": "pride (Emilya) is none of the five",
    "ashamed shame shameful guilt guilty embarrassed embarrassment": (
        "shame (Emilya) and its kin are near sadness in what people see, but not the same"
    ),
    "jealous jealousy envious envy": "none of the five",
}
"""Emotions outside the five, with the reason; an answer that commits to one is `other`."""

NEAR_WORDS: dict[str, str] = {
    "calm calmly calmness relaxed serene peaceful composed": (
        "a pleasant state of its own, not the absence of one"
    ),
    "content contented contentment satisfied pleased amused": "milder than joy",
    "excited excitement excitedly enthusiastic energetic": "arousal; its valence is open",
    "nervous nervously nervousness worried worry uneasy apprehensive stressed tense": (
        "kin of anxiety, which Emilya keeps apart from fear"
    ),
    "frustrated frustration annoyed annoyance irritated irritation agitated agitation": (
        "milder than anger"
    ),
    "aggressive aggression aggressively hostile hostility": "behaviour, whatever is felt",
    "upset distressed distress": "anger, fear and sadness share it",
    "depressed depression disappointed disappointment lonely hopeless gloomy": (
        "a lasting mood or a thought, beside sadness"
    ),
    "tired exhausted bored boredom confused confusion confident thoughtful curious determined": (
        "states of body and mind, not emotions of the list"
    ),
    "positive negative mixed": "a valence, not an emotion",
    "normal": "a manner of moving in most sentences",
}
"""Doubtful words: alone they are `other`, beside a label word they decide nothing."""

EMOJI: dict[str, Emotion] = {
    **dict.fromkeys("😠😡🤬", "angry"),
    **dict.fromkeys("😨😱", "fearful"),
    **dict.fromkeys("😀😃😄😁😊🙂", "happy"),
    **dict.fromkeys("😐😑😶", "neutral"),
    **dict.fromkeys("😢😭😞🙁☹", "sad"),
}
"""Counted only where an answer has no word of the tables."""

_MEANINGS: dict[str, Meaning] = {
    **{word: "near" for words in NEAR_WORDS for word in words.split()},
    **{word: "outside" for words in OUTSIDE_WORDS for word in words.split()},
    **{word: emotion for emotion, words in EMOTION_WORDS.items() for word in words.split()},
}


def meaning_of(word: str) -> Meaning | None:
    """What a word in lower case stands for; `None` if the tables do not have it.

    Examples:
        >>> meaning_of("furious"), meaning_of("surprised"), meaning_of("chair")
        ('angry', 'outside', None)
    """
    return _MEANINGS.get(word)


def words_table() -> str:
    """The words of each emotion, as the Markdown table of docs/answers.md."""
    rows = [
        f"| {name} | {', '.join(EMOTION_WORDS[name].split())} | {' '.join(_emoji_of(name))} |"
        for name in EMOTIONS
    ]
    return "\n".join(["| emotion | words | emoji |", "|---|---|---|", *rows])


def decisions_table() -> str:
    """The words that stand for none of the five, and why, as the table of docs/answers.md."""
    rows = [
        f"| {', '.join(words.split())} | {kind} | {why} |"
        for kind, table in (("outside", OUTSIDE_WORDS), ("near", NEAR_WORDS))
        for words, why in table.items()
    ]
    return "\n".join(["| words | kind | why |", "|---|---|---|", *rows])


def _emoji_of(emotion: Emotion) -> list[str]:
    return [sign for sign, name in EMOJI.items() if name == emotion]
