"""How models and results show themselves in a notebook, and as graphs of networkx."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import networkx as nx


class Displayed:
    """A model or result that a notebook draws; no other package is needed for it."""

    __slots__ = ()

    def _repr_svg_(self) -> str:
        from tracerisk.prm.drawing import svg_of

        return svg_of(self)

    def _repr_html_(self) -> str:
        from tracerisk.prm.drawing import html_of

        return html_of(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        # The text that stands beside the drawing: all the fields of a large model are no help.
        from tracerisk.prm.drawing import text_of

        return {"text/plain": text_of(self)}


class DisplayedGraph(Displayed):
    """A model that is a directed graph as well."""

    __slots__ = ()

    def to_networkx(self) -> nx.DiGraph:
        """Return the model as a directed graph of networkx, its figures as attributes.

        The attribute `kind` says what a node is.
        Of a fault tree, edges lead from a gate to its inputs; of a chain or hybrid model, from a
        state to what may follow it, with its `probability` or, of what follows given that
        nothing failed, its `weight`.
        Raises ModelError when networkx, of the extra `graph`, is not installed.
        """
        from tracerisk.prm.notebook.graphs import graph_of

        return graph_of(self)
