"""Chains in the language of the PRISM model checker, which Storm reads too."""

from tracerisk.prm.other_models.formats.prism.prism_reader import read_prism
from tracerisk.prm.other_models.formats.prism.writer import write_prism

__all__ = ["read_prism", "write_prism"]
