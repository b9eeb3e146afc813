"""Minimal cut sets, and prime implicants of trees that are not coherent."""

from tracerisk.prm.other_models.cut_sets.cut_sets import CutSet, CutSets
from tracerisk.prm.other_models.cut_sets.finding import minimal_cut_sets, prime_implicants

__all__ = ["CutSet", "CutSets", "minimal_cut_sets", "prime_implicants"]
