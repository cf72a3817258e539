"""What the Hub's refusals mean to a user, whatever the version of its client calls them."""

from __future__ import annotations

__all__ = ["explained", "is_unreachable", "not_here"]


def is_unreachable(error: Exception) -> bool:
    """Whether no Hub answered, or one that could not for now, so that a local copy may do."""
    response = getattr(error, "response", None)
    return response is None or response.status_code == 429 or response.status_code >= 500


def not_here(place: str, name: str) -> FileNotFoundError:
    """For a file of a revision that would have to be fetched, which is impossible."""
    return FileNotFoundError(
        f"{place}: {name} is not in the local cache and the Hub cannot be reached; "
        "check the network, and HF_HUB_OFFLINE"
    )


def explained(error: Exception, place: str, name: str, *, begun: bool = False) -> Exception:
    """The error to raise for one of the client.

    Args:
        error: What the client raised.
        place: The address of the revision.
        name: The file that was asked for.
        begun: Whether some of the file had come.
    """
    from huggingface_hub.errors import (
        EntryNotFoundError,
        GatedRepoError,
        RepositoryNotFoundError,
        RevisionNotFoundError,
    )

    match error:
        case RevisionNotFoundError():
            return FileNotFoundError(f"{place}: there is no such revision")
        case GatedRepoError():
            return FileNotFoundError(
                f"{place}: its authors want to be asked; ask on its page, then `hf auth login`"
            )
        case RepositoryNotFoundError():
            return FileNotFoundError(
                f"{place}: no such dataset, or it is private; `hf auth login` if it is yours"
            )
        case EntryNotFoundError():
            return FileNotFoundError(f"{place}: has no {name}; the release is incomplete")
    if getattr(error, "response", None) is None and not begun:
        return not_here(place, name)
    return ConnectionError(f"{place}: fetching {name} failed: {error}")
