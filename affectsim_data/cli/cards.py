"""The command that describes a release for others: `card`."""

from __future__ import annotations

from json import dumps
from pathlib import Path

import tyro

__all__ = ["card"]


def card(
    release: tyro.conf.Positional[str],
    *,
    out: Path | None = None,
    contact: str | None = None,
    published: str | None = None,
    json: bool = False,
) -> int:
    """Write the dataset card of a release, its Croissant file and the pictures they show.

    README.md is for people and the Hugging Face Hub, croissant.json for machines; `upload` sends
    both. Pages that somebody wrote or edited are left alone. Needs the extra `plots`.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        out: Where they go; into the folder of the release if not given.
        contact: Whom to tell of misuse: an address of mail or of a page.
        published: Day of publication, YYYY-MM-DD, which Croissant recommends to state.
        json: Print JSON.
    """
    from affectsim_data.cards import write_pages
    from affectsim_data.releases import open_release

    opened = open_release(release)
    if out is None and opened.is_remote:
        raise ValueError(f"{release}: is not in a folder; say with --out where its pages go")
    folder = Path(opened.uri) if out is None else out.expanduser()
    names = write_pages(opened, folder, contact=contact, published=published)
    sizes = {name: (folder / name).stat().st_size for name in names}
    if json:
        print(dumps({"release": opened.uri, "folder": str(folder), "files": sizes}, indent=2))
    else:
        print(f"{folder}: {', '.join(names)}")
    return 0
