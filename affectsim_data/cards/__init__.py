"""The pages a release carries: a card the Hugging Face Hub understands, and Croissant."""

from affectsim_data.cards.writing import (
    dataset_card,
    has_own_card,
    published_pages,
    write_card,
    write_pages,
)

__all__ = ["dataset_card", "has_own_card", "published_pages", "write_card", "write_pages"]
