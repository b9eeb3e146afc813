"""`launch.logging`: what launch files log goes to standard error."""

from __future__ import annotations

import logging


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger."""
    return logging.getLogger(name)
