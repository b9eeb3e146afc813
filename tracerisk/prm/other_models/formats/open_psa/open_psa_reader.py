"""Open-PSA XML files, one or several, as one model."""

from __future__ import annotations

import os

from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.other_models.formats.open_psa.collecting import (
    CONTAINERS,
    ROOT,
    ROOTS,
    Collector,
)
from tracerisk.prm.other_models.formats.open_psa.linking import Linker
from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element, parse
from tracerisk.prm.other_models.logic.model import LogicModel

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

_WHOLE = tuple(f"xpointer(/{root}/*)" for root in ROOTS)
"""What of a file is included: all that its root holds."""
_MOST_FILES = 1_000


def read_open_psa(path: Path | str, *more: Path | str) -> LogicModel:
    """Read the model that one or several Open-PSA XML files hold together.

    Raises ModelError with file, line and column, and what is allowed, when a file cannot be read,
    is not XML, declares entities, or holds what Open-PSA or this reader does not allow.
    """
    return _read([(name, name) for name in map(str, (path, *more))])


def loads_open_psa(text: str | bytes, file: str) -> LogicModel:
    """Read a model from XML text; `file` is its name in messages.

    Raises ModelError as `read_open_psa` does.
    """
    return _read([(text.encode() if isinstance(text, str) else text, file)])


def _read(sources: list[tuple[str | bytes, str]]) -> LogicModel:
    collector = Collector()
    try:
        with collection_paused():
            return _collected(sources, collector)
    finally:
        # What is old when a pause ends is not looked through for what refers back.
        collector.release()


def _collected(sources: list[tuple[str | bytes, str]], collector: Collector) -> LogicModel:
    # Each with the files that include it, the outermost first.
    waiting: list[tuple[str | bytes, str, tuple[str, ...]]] = [(*row, ()) for row in sources]
    for count, (source, file, above) in enumerate(waiting, start=1):
        includes: list[Element] = []
        root = parse(
            source, file, ROOTS, CONTAINERS, collector.enter, collector.take, includes.append
        )
        if root.tag != ROOT:
            root.fail(f"<{root.tag}> is not an Open-PSA model; the root must be <{ROOT}>")
        if count > _MOST_FILES:
            root.fail(f"more than {_MOST_FILES} files belong to the model; merge some")
        collector.finish_file(root)
        chain = above if isinstance(source, bytes) else (*above, os.path.realpath(source))
        paths = [_included(include, source, chain) for include in includes]
        waiting += [(path, path, chain) for path in paths]
    return Linker(collector).model()


def _included(element: Element, source: str | bytes, above: tuple[str, ...]) -> str:
    """Return the file that an element includes."""
    element.check_attributes("href", "xpointer")
    pointer = element.attributes.get("xpointer", _WHOLE[0]).replace(" ", "")
    if pointer not in _WHOLE and pointer not in (f"/{root}/*" for root in ROOTS):
        element.fail(f"the xpointer '{pointer}' is not supported; allowed: {_WHOLE[0]}")
    if isinstance(source, bytes):
        element.fail(
            "includes a file, but a model text has no folder to include from; read the "
            "model from a file"
        )
    href = element.attribute("href")
    path = os.path.join(os.path.dirname(source), href)  # noqa: PTH118, PTH120 - no start needs pathlib
    if os.path.realpath(path) in above:
        element.fail(f"'{href}' includes itself; break the cycle")
    return path
