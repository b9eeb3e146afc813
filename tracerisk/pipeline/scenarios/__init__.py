"""Draft the scenario that a controller needs."""
