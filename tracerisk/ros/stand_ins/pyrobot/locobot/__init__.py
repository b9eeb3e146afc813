"""The parts of a LoCoBot."""
