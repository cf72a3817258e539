"""Furniture catalogues: Sweet Home 3D libraries and folders of models with their sizes."""

from affectsim_data.builders.homes.catalogue.catalogue import Catalogue, read_catalogue
from affectsim_data.builders.homes.catalogue.entries import CatalogueEntry

__all__ = ["Catalogue", "CatalogueEntry", "read_catalogue"]
