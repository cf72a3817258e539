"""Words that deny, list, hedge, weigh or state an emotion in a sentence."""

from __future__ import annotations


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


AND = _words("and & +")
OR = _words("or nor / |")
FILLERS = _words(
    "a an the any very even also visible obvious clear overt evident signs sign of strong his her "
    "their its is it's in hints"
)
"""Stand between the words of an enumeration without ending it."""
LIST_CUES = _words(
    "options option among choices choose labels categories emotions classes one between from "
    "candidates following list select pick"
)
"""Announce the options."""

NOT = _words(
    "not cannot isnt doesnt dont cant wasnt arent didnt never hardly barely scarcely neither nor "
    "non nothing nobody unlike"
)
NO = _words("no without lack lacks lacking absence devoid free none")
"""Deny a noun; these also reach through a list of commas: `no anger, fear`."""
RULES_OUT = _words("rule rules ruled ruling exclude excludes excluding")
"""Deny what follows; forms of `rule` only with `out` behind them."""
PARTNERS = {"instead": "of", "opposed": "to", "far": "from", "anything": "but"}
"""First words of `instead of` and its kin, which deny like `rather than`."""
BREAKS = _words(
    "but yet however although though while whereas because so which therefore thus hence instead "
    "despite since as : ( ) [ ] -"
)
"""End what a denial reaches."""
FINITE = _words(
    "suggests suggest indicates indicate conveys convey points implies imply reflects reflect "
    "signals makes"
)
PARTICIPLES = _words(
    "suggesting indicating implying conveying expressing showing displaying signaling reflecting "
    "revealing signalling"
)
"""Begin a statement of their own: `not moving much, suggesting sadness`."""
UNSURE = _words("sure certain clear confident positive know tell")
"""After `not` they doubt and deny nothing."""
COPULAS = _words("is are was does do can could seems appears isn't doesn't aren't")
DENIALS_AFTER = _words(
    "not unlikely improbable absent ruled excluded isn't doesn't aren't cannot can't missing "
    "lacking"
)
"""Deny the word before: `anger is unlikely`."""

WEAK = _words(
    "possibly perhaps maybe might may could hint hints touch trace traces bit slight slightly "
    "little some somewhat also secondary secondarily initially although though while despite even "
    "albeit whereas alternatively undertone undertones tinge tinged bordering potentially first "
    "mistaken conceivably elements element followed >"
)
"""Hedge what follows; `>` because in a ranking only its head is free of it."""
RANKED = _words("guess choice option candidate most possibility")
"""What a `second` one of is a hedge."""
STRONG = _words(
    "mainly mostly primarily predominantly chiefly most best dominant primary main definitely "
    "stronger strongest certainly overall therefore thus hence conclude conclusion summary settle "
    "choose chose pick select answer lean leaning leans likeliest largely above now"
)
"""Weigh or conclude."""
LASTING = WEAK | STRONG | {"likely"}
"""Words whose effect outlasts a comma behind them: `more likely, fearful`."""
STRONG_AFTER = _words(
    "stronger strongest dominant dominates prevails best fitting primary main answer likelier "
    "likeliest"
)
"""Weigh the word before: `sadness is the stronger emotion`."""
SAYING = _words("say guess go classify describe label call categorize interpret")
"""Conclude after `I would`."""
STATING = _words(
    "is are was were be being 's seems seem seemed appears appear appeared looks look looking "
    "feels feel feeling sounds shows show showing expresses express expressing displays display "
    "displaying conveys convey conveying exhibits exhibit exhibiting experiencing experiences "
    "indicates indicate indicating suggests suggest suggesting reflects reflect reflecting signals "
    "communicates portrays portraying demonstrates becomes remains emotion mood it's he's she's "
    "they're i'm expressed classified described maintains has"
)
"""Say that what follows is meant of the person."""

TURNS = _words("but however although though yet : -")
SUBJECTS = _words("i they he she it the this these his her their my we")
"""Begin a clause of its own after a refusal, the latter behind a comma."""
HEAD_ENDS = _words("- : ( ) , because as since with given due")
"""Follow a word that opens its sentence as the answer."""
BARE_FILLERS = _words(
    "a an the very so i think it is it's feeling emotion mood state clearly definitely just "
    "person extremely quite really probably overall expression of and - : , ( ) [ ] ' \" < > \\ / "
    "{ } $ # | = +"
)
"""Leave a sentence with one label an answer in one word."""
