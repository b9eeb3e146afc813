"""The formats of other tools, and of models that no controller makes."""
