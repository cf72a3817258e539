"""The behaviour m: labelled performances on the 22-joint skeleton, and how corpora become them."""

from affectsim_data.motions.motion import EMOTIONS, Emotion, Motion, emotion_label

__all__ = ["EMOTIONS", "Emotion", "Motion", "emotion_label"]
