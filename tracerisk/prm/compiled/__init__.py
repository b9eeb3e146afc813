"""The loops that decide how fast trees are solved, compiled when tracerisk is installed."""
