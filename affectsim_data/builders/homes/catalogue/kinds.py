"""What a piece of a catalogue is, told from its name."""

from __future__ import annotations

import re

__all__ = ["SEATS", "TABLES", "WALL_HUNG", "kinds_of"]

_RULES: tuple[tuple[tuple[str, ...], str, str], ...] = (
    (("nightstand", "cabinet"), r"bedside|night ?stand|night ?table", ""),
    (
        ("lamp",),
        r"lamp|lantern",
        r"wall|ceiling|pendant|street|outdoor|stone|chandelier|post|camping",
    ),
    (("tv",), r"^tv\b|^television$|\btv 16|flat tv", r"cabinet|remote|wall|stand"),
    (("plant",), r"plant|cactus|orchid|ficus|bonsai|bamboo|aloe", r"box|hanging"),
    (("bench",), r"bench", r"work|press|abdominal|weight"),
    (("stool",), r"stool|\bpuff\b|\bpouf", r"bar stool|kitchen stool"),
    (("bar_stool", "stool"), r"bar stool|kitchen stool", ""),
    (("armchair",), r"armchair|relax chair|rocking chair|club chair", r"garden|rattan"),
    (("desk_chair", "chair"), r"office chair|desk chair|swivel", ""),
    (
        ("chair",),
        r"chair",
        r"deck|beach|baby|high chair|child|kid|wheel|bar chair|electric|garden|ryokan|lounge",
    ),
    (("sofa",), r"sofa|couch|settee|loveseat", r"opened|bed|garden|rattan"),
    (("crib",), r"crib|baby bed|cradle", ""),
    (
        ("bed",),
        r"\bbed\b",
        r"hospital|mezzanine|child|bunk|day|air|dog|flower|canopy|opened|baby|crib",
    ),
    (("wardrobe",), r"wardrobe|closet|armoire", r"locker"),
    (("dresser", "cabinet", "sideboard"), r"dresser|drawers|commode|chest of", ""),
    (
        ("sideboard", "cabinet"),
        r"sideboard|buffet|television cabinet|tv (cabinet|unit|stand)|credenza",
        "",
    ),
    (("cabinet", "shelf"), r"glass door cabinet|display cabinet|cupboard", r"upper"),
    (("shelf",), r"bookcase|book ?shel|\bshel(f|ves)\b|bookshelf", r"upper|wall"),
    (("desk",), r"\bdesk\b|office table|wooden table office", r"lamp|chair|kid"),
    (("coffee_table", "table"), r"coffee table|saloon table|living room table|side table", ""),
    (
        ("table",),
        r"\btable\b",
        r"pool|football|changing|dressing|fan|child|kid|technical|tennis|operating|garden|bar |lamp"
        r"|massage|trestle|rattan|billiard|water",
    ),
    (("fridge",), r"fridge|refrigerator", ""),
    (("oven",), r"^(oven|range)$|double oven|gas cooker", ""),
    (("washing_machine",), r"washing machine|dryer machine|washer", ""),
    (("toilet",), r"toilets? unit|^toilets?$|^wc$", ""),
    (("basin",), r"wash ?basin|vanity|lavatory|sink cabinet|pedestal sink", r"double"),
    (("bathtub",), r"^bath$|bathtub|bath tub", r"corner|island"),
    (("shower",), r"shower (stall|unit|cabin)|^shower$", ""),
    (("radiator",), r"radiator", ""),
    (("piano",), r"piano", r"bench|stool"),
    (("speaker",), r"speaker", ""),
    (("monitor",), r"^(computer )?monitor$", ""),
    (("basket",), r"basket$|^dustbin$|waste|bin$", r"basketball|shopping"),
)
"""Categories, what the name must say, and what it must not; the first that fits counts."""
_OUTDOORS = re.compile(r"exterior|outdoor|garden|vehicle|character|staircase|door|light.*ceiling")

SEATS = frozenset({"chair", "armchair", "sofa", "bench", "stool", "desk_chair"})
"""Categories one sits on."""
TABLES = frozenset(
    {"table", "coffee_table", "desk", "nightstand", "cabinet", "dresser", "sideboard", "shelf"}
)
"""Categories one puts things on."""
WALL_HUNG = frozenset({"basin", "radiator"})
"""Categories that may hang above the floor."""


def kinds_of(name: str, *, group: str = "") -> tuple[str, ...]:
    """The categories a piece may stand in for, the closest first; empty if it is none of ours.

    Args:
        name: English name, for example `Bedside table`.
        group: Where the catalogue lists it, for example `Bedroom`.

    Examples:
        >>> kinds_of("Bedside table", group="Bedroom")
        ('nightstand', 'cabinet')
        >>> kinds_of("Deck chair", group="Exterior")
        ()
    """
    if _OUTDOORS.search(group.lower()):
        return ()
    plain = name.lower().replace("_", " ").strip()
    for kinds, wanted, unwanted in _RULES:
        if re.search(wanted, plain):
            return () if unwanted and re.search(unwanted, plain) else kinds
    return ()
