"""Stand-in for baxter_dataflow: waiting, and signals."""

from .signals import Signal
from .wait_for import wait_for

__all__ = ["Signal", "wait_for"]
