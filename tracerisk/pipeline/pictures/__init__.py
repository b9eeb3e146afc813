"""Pictures and replays of runs, for reports."""
