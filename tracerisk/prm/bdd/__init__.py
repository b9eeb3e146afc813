"""Binary decision diagrams: the exact probability of fault trees that share events."""

from tracerisk.prm.bdd.shared_tree import SharedTree, compiled, with_bounds

__all__ = ["SharedTree", "compiled", "with_bounds"]
