"""The baseline that stands still, scans, searches, goes to a good view and follows."""
