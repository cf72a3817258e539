"""Camera trajectories: one module per condition."""
