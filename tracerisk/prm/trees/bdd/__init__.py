"""Binary decision diagrams: the exact probability of fault trees that share events."""

from tracerisk.prm.trees.bdd.shared_tree import SharedTree, with_bounds

__all__ = ["SharedTree", "with_bounds"]
