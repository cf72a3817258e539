"""Looking at releases: contact sheets, Rerun recordings, and what this machine can draw.

Each module is imported where it is used: counting episodes needs neither torch nor Rerun.
"""
