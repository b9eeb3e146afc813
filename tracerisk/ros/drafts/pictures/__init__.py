"""Pictures that a scenario can publish, and what a controller sees in them."""
