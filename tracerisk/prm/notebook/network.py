"""Bayesian networks as drawings."""

from __future__ import annotations

from tracerisk.prm.drawing.chain import Arrow, states_svg
from tracerisk.prm.other_models.bayes.network import BayesianNetwork


def network_svg(network: BayesianNetwork) -> str:
    """Return the drawing of a network: its conditions, and the events that depend on them."""
    events = {
        name: f"{name} (event)" if name in network.conditions else name for name in network.events
    }
    arrows = {
        (parent, name): Arrow("") for name in network.conditions for parent in network.parents(name)
    }
    for name, shown in events.items():
        for parent in network.events[name].names:
            arrows[parent, shown] = Arrow("")
    count = len(network.conditions) + len(events)
    sources = list(network.conditions)
    return states_svg(sources, tuple(events.values()), arrows, count, "Bayesian network")
