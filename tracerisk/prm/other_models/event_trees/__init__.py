"""Event trees: built, checked, solved."""
