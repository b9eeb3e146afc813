"""Stand-in for intera_dataflow: waiting and signals, as baxter_dataflow has them."""

from baxter_dataflow import Signal, wait_for

__all__ = ["Signal", "wait_for"]
