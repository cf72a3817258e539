"""The data folders are found, and nothing outside them."""

from __future__ import annotations

from pathlib import Path

import pytest

from affectsim_data import content
from affectsim_data.content import ContentFolder, content_names, content_path

FOLDERS: tuple[ContentFolder, ...] = ("builders", "cards", "loaders", "schemas")


@pytest.mark.parametrize("folder", FOLDERS)
def test_folders_are_found_and_explain_themselves(folder: ContentFolder) -> None:
    assert content_path(folder).is_dir()
    assert (content_path(folder) / "README.md").is_file()


def test_names_are_sorted_stems() -> None:
    names = content_names("loaders", ".toml")
    assert names == sorted(names)
    assert {"p_init", "p_mon", "p_ref", "8x224"} <= set(names)
    assert "README" not in names


def test_a_missing_file_lists_what_there_is() -> None:
    with pytest.raises(FileNotFoundError, match=r"no 'p_none\.toml' in loaders/ .*p_init\.toml"):
        content_path("loaders", "p_none.toml")


@pytest.mark.parametrize("name", ["../pyproject.toml", "/etc/passwd", "a/../../cards/README.md"])
def test_names_may_not_lead_out(name: str) -> None:
    with pytest.raises(ValueError, match="leads out of loaders/"):
        content_path("loaders", name)


def test_an_installed_package_carries_its_own_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = tmp_path / "package" / "content" / "cards"
    beside = tmp_path / "cards"
    for folder in (inside, beside):
        folder.mkdir(parents=True)
        (folder / "card.md").write_text(folder.parent.name)
    monkeypatch.setattr(content, "_PACKAGE", tmp_path / "package")
    assert content_path("cards", "card.md").read_text() == "content"
    (inside / "card.md").unlink()
    inside.rmdir()
    assert content_path("cards", "card.md").read_text() == tmp_path.name
