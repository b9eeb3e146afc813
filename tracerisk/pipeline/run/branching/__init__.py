"""Runs with faults as branches of one run, which is forked before each fault."""
