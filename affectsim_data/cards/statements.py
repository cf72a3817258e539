"""What the pages of a release say in words: texts of `cards/`, with the release's own numbers."""

from __future__ import annotations

import dataclasses
import re
from string import Template

from affectsim_data.cards.facts import Facts
from affectsim_data.content import content_path

__all__ = ["Statements", "unmarked"]


@dataclasses.dataclass(frozen=True)
class Statements:
    """Texts of `cards/*.md` filled in for a release; card and Croissant say the same."""

    facts: Facts

    def text(self, name: str) -> str:
        """One text, Markdown."""
        manifest, facts = self.facts.manifest, self.facts
        template = Template(content_path("cards", f"{name}.md").read_text(encoding="utf-8"))
        return template.substitute(
            num_scenes=f"{manifest.num_rows('scenes'):,}",
            num_motions=f"{manifest.num_rows('motions'):,}",
            num_avatars=f"{manifest.num_rows('avatars'):,}",
            num_procedural=f"{facts.num_procedural:,}",
            num_recorded=f"{facts.num_recorded:,}",
        ).strip()

    def labels(self) -> list[str]:
        """How the labels of the motions that are there came about, Markdown."""
        kinds = (
            ("labels_procedural", self.facts.num_procedural),
            ("labels_recorded", self.facts.num_recorded),
        )
        return [self.text(name) for name, count in kinds if count]

    def sentence(self, name: str) -> str:
        """One text as a line of plain text."""
        return unmarked(self.text(name))

    def items(self, name: str) -> list[str]:
        """The items of a text that is a list, each a line of plain text."""
        return [unmarked(item) for item in re.split(r"^- ", self.text(name), flags=re.M) if item]


def unmarked(text: str) -> str:
    """Markdown of our own as plain text on one line."""
    return " ".join(re.sub(r"[*`\\]", "", text).split())
