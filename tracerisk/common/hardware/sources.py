"""Which figures of a description have no source, or none but an assumption."""

from __future__ import annotations

from tracerisk.common.hardware.model import Hardware, is_assumed


def assumed_sources(hardware: Hardware) -> dict[str, str]:
    """Return what each component with assumed figures says of them, in the order of the file.

    A figure's source is its own, else that of its component, else that of the description; it
    is assumed where that begins with the word.
    """
    sources_of = {}
    for component in hardware.components:
        default = component.source or hardware.source
        stated = [figure.source or default for figure in component.figures]
        assumed = [source for source in stated if source is not None and is_assumed(source)]
        assumed += [
            source if source in stated else f"{source} (of its load law or modes alone)"
            for source in component.law_sources
            if source is not None and is_assumed(source)
        ]
        if assumed:
            words = "; ".join(" ".join(name.split()) for name in dict.fromkeys(assumed))
            count = sum(source is not None and is_assumed(source) for source in stated)
            if 0 < count < len(stated):
                words += f" ({count} of its {len(stated)} figures; the share is that of all)"
            sources_of[component.name] = words
    return sources_of


def without_source(hardware: Hardware) -> tuple[str, ...]:
    """Return the components of which a figure has no source at all, in the order of the file."""
    return tuple(
        component.name
        for component in hardware.components
        if not (component.source or hardware.source)
        and any(figure.source is None for figure in component.figures)
    )
