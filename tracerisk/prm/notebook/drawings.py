"""Drawings of models and results, as SVG and HTML that need no other package."""

from __future__ import annotations

from html import escape

from tracerisk.prm.drawing.assessment import assessment_html, assessment_svg, assessment_text
from tracerisk.prm.drawing.chain import chain_svg, hybrid_svg
from tracerisk.prm.drawing.fault_tree import fault_tree_svg
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.notebook.event_tree import event_tree_svg
from tracerisk.prm.notebook.network import network_svg
from tracerisk.prm.other_models.bayes.network import BayesianNetwork
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.markov import MarkovChain
from tracerisk.prm.trees.fault_tree import FaultTree

__all__ = ["html_of", "svg_of", "text_of"]


def svg_of(shown: object) -> str:
    """Return the drawing of a model or result."""
    match shown:
        case FaultTree():
            return fault_tree_svg(shown)
        case MarkovChain():
            return chain_svg(shown.transitions, shown.absorbing, "Markov chain")
        case HybridModel():
            return hybrid_svg(shown)
        case EventTree():
            return event_tree_svg(shown)
        case BayesianNetwork():
            return network_svg(shown)
        case Assessment():
            return assessment_svg(shown)
    raise TypeError(f"{type(shown).__name__} cannot be drawn")


def html_of(shown: object) -> str:
    """Return a model or result as HTML: its figures, or its size, and its drawing."""
    if isinstance(shown, Assessment):
        return f"<div>{assessment_html(shown)}{assessment_svg(shown)}</div>"
    text = escape(_size_of(shown))
    return f"<figure>{svg_of(shown)}<figcaption>{text}</figcaption></figure>"


def text_of(shown: object) -> str:
    """Return a model or result as text: its figures, or its size."""
    return assessment_text(shown) if isinstance(shown, Assessment) else _size_of(shown)


def _size_of(shown: object) -> str:
    match shown:
        case FaultTree():
            return f"Fault tree {shown.top}: {len(shown.gates)} gates, {len(shown.events)} events"
        case MarkovChain():
            return (
                f"Markov chain: {len(shown.transitions)} transient and {len(shown.absorbing)} "
                "absorbing states"
            )
        case HybridModel():
            return (
                f"{shown.name}: {len(shown.states)} functions, {len(shown.parameters)} parameters"
            )
        case EventTree():
            return f"Event tree {shown.name}: {len(shown.sequences)} sequences"
        case BayesianNetwork():
            return (
                f"Bayesian network: {len(shown.conditions)} conditions, {len(shown.events)} events"
            )
    raise TypeError(f"{type(shown).__name__} cannot be drawn")
