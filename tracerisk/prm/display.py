"""How models and results show themselves in a notebook, and as graphs of networkx."""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    import networkx as nx


class Displayed:
    """A model or result that a notebook draws; no other package is needed for it."""

    __slots__ = ()

    def _repr_svg_(self) -> str:
        drawn: str = _by_name("tracerisk.prm.notebook.drawings", "svg_of", self)
        return drawn

    def _repr_html_(self) -> str:
        drawn: str = _by_name("tracerisk.prm.notebook.drawings", "html_of", self)
        return drawn

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        # The text that stands beside the drawing: all the fields of a large model are no help.
        return {"text/plain": _by_name("tracerisk.prm.notebook.drawings", "text_of", self)}


class AsGraph:
    """A model that is a directed graph as well."""

    __slots__ = ()

    def to_networkx(self) -> nx.DiGraph:
        """Return the model as a directed graph of networkx, its figures as attributes.

        The attribute `kind` says what a node is.
        Of a fault tree, edges lead from a gate to its inputs; of a chain or hybrid model, from a
        state to what may follow it, with its `probability` or, of what follows given that
        nothing failed, its `weight`; of a linked model, from an element, as "fault tree 'pick'",
        to what takes its figure.
        Raises ModelError when networkx, of the extra `graph`, is not installed.
        """
        return _by_name("tracerisk.prm.notebook.graphs", "graph_of", self)


class DisplayedGraph(Displayed, AsGraph):
    """A model that a notebook draws, and that is a directed graph as well."""

    __slots__ = ()


def _by_name(module: str, function: str, shown: object) -> Any:
    """Call the drawing function by name: its module imports every model, so none can import it."""
    return getattr(import_module(module), function)(shown)
