"""The sections that only served pages have: links, sliders, and what reloads a stale page."""

from __future__ import annotations

from markupsafe import Markup

from tracerisk.cli.serving.model_changes import (
    FASTEST,
    LEAST,
    MOST,
    RATE,
    SLOWEST,
    SPEED,
    UNITS,
    Choices,
)
from tracerisk.report.html import figures
from tracerisk.report.html.page import asset, rendered
from tracerisk.report.html.section import Section


def links_section(name: str, report: str, history: str) -> Section:
    """Return where to read on about a controller."""
    html = rendered("served_links.html.j2", name=name, report=report, history=history)
    return Section("more", "Read on", html)


def what_if_section(choices: Choices, address: str) -> Section:
    """Return the sliders; `address` is where their script asks what comes of them."""
    rows = [
        {
            "name": component.name,
            "figure": figures.probability(component.figure),
            "rate": f"{RATE}{component.name}",
            "units": f"{UNITS}{component.name}",
            "now": f"{component.required} of {component.quantity}",
            "choices": [
                {"value": f"{k}of{n}", "text": f"{k} of {n}"}
                for k, n in component.units
                if (k, n) != (component.required, component.quantity)
            ],
        }
        for component in choices.components
    ]
    html = rendered(
        "what_if.html.j2",
        rows=rows,
        notes=choices.notes,
        address=address,
        speed=SPEED if choices.has_speed else "",
        rates=(LEAST, MOST),
        speeds=(SLOWEST, FASTEST),
    )
    return Section("what-if", "What if", html, css=asset("what_if.css"), js=asset("what_if.js"))


def live_section() -> Section:
    """Return what reloads the page when a file has changed."""
    return Section("live", "", Markup(""), js=asset("live.js"), is_bare=True)
