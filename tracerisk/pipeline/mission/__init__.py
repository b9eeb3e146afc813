"""What a run did for its mission, and whether that is what `success` of a scenario declares."""
