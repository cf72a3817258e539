"""SVG files as parts of a page: nothing in them but shapes and text, and names of their own."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from markupsafe import Markup

from affectsim_data.inspection.figures import INK

__all__ = ["inline_svg"]

_SVG, _LINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}href"
_TAGS = frozenset({"svg", "g", "defs", "path", "rect", "use", "clipPath", "text", "tspan"})
_ATTRIBUTES = frozenset(
    {"id", "d", "style", "transform", "x", "y", "width", "height", "viewBox", "clip-path"}
)
_REFERENCE = re.compile(r"url\(#([\w-]+)\)")


def inline_svg(data: bytes, name: str, *, label: str) -> Markup:
    """The picture as an element of a page, in the page's own ink.

    Elements and attributes that matplotlib does not need to show shapes and text are left out.

    Args:
        data: SVG file.
        name: Put before the names inside, so that pictures of one page do not share them.
        label: What a reader hears who does not see it.

    Raises:
        ValueError: It is no SVG file.
    """
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise ValueError(f"figure {name!r} is no SVG file: {error}") from error
    if root.tag != f"{_SVG}svg":
        raise ValueError(f"figure {name!r} is no SVG file: its root is {root.tag!r}")
    used = _references(root)
    cleaned = _cleaned(root, name, used)
    for size in ("width", "height"):
        cleaned.attrib.pop(size, None)
    cleaned.attrib |= {"role": "img", "aria-label": label}
    # Parsed and written again: whatever text there is comes out escaped.
    return Markup(ElementTree.tostring(cleaned, encoding="unicode"))


def _references(root: ElementTree.Element) -> set[str]:
    """Names that something in the picture points to."""
    found = {link.removeprefix("#") for one in root.iter() if (link := one.get(_LINK))}
    for one in root.iter():
        found |= {name for value in one.attrib.values() for name in _REFERENCE.findall(value)}
    return found


def _cleaned(element: ElementTree.Element, name: str, used: set[str]) -> ElementTree.Element:
    """A copy without strange elements and attributes; links stay inside the picture."""
    copy = ElementTree.Element(element.tag.removeprefix(_SVG))
    for key, value in element.attrib.items():
        if key == _LINK and value.startswith("#"):
            copy.set("href", f"#{name}-{value[1:]}")
        elif key == "id" and value in used:
            copy.set("id", f"{name}-{value}")
        elif key in _ATTRIBUTES and key != "id":
            inside = _REFERENCE.sub(rf"url(#{name}-\1)", value)
            copy.set(key, inside.replace(INK, "currentColor"))
    copy.text = element.text if copy.tag in ("text", "tspan") else None
    for child in element:
        if child.tag in {f"{_SVG}{tag}" for tag in _TAGS}:
            copy.append(_cleaned(child, name, used))
    return copy
