"""Builds releases from recipes: bodies, homes, performances, and the episodes that join them."""
