"""`check`, `refresh`, `overrides`: can the blocks be trusted, and bring them up to date."""
