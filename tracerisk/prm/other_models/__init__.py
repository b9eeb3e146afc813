"""Models that no controller makes: other tools' formats, and the kinds of models in them."""
