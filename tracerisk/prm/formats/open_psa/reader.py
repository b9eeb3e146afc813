"""Open-PSA XML files, one or several, as one model."""

from __future__ import annotations

from pathlib import Path

from tracerisk.prm.formats.open_psa.collecting import CONTAINERS, ROOT, Collector
from tracerisk.prm.formats.open_psa.linking import Linker
from tracerisk.prm.formats.open_psa.xml_elements import parse
from tracerisk.prm.logic.model import LogicModel
from tracerisk.prm.numbers.gc_pause import collection_paused


def read_open_psa(path: Path | str, *more: Path | str) -> LogicModel:
    """Read the model that one or several Open-PSA XML files hold together.

    Raises ModelError with file, line and column, and what is allowed, when a file cannot be read,
    is not XML, declares entities, or holds what Open-PSA or this reader does not allow.
    """
    return _read([(Path(each), str(each)) for each in (path, *more)])


def loads_open_psa(text: str | bytes, file: str) -> LogicModel:
    """Read a model from XML text; `file` is its name in messages.

    Raises ModelError as `read_open_psa` does.
    """
    return _read([(text.encode() if isinstance(text, str) else text, file)])


def _read(sources: list[tuple[Path | bytes, str]]) -> LogicModel:
    collector = Collector()
    with collection_paused():
        for source, file in sources:
            root = parse(source, file, CONTAINERS, collector.enter, collector.take)
            if root.tag != ROOT:
                root.fail(f"<{root.tag}> is no Open-PSA model; the root is <{ROOT}>")
            collector.finish_file(root)
        model = Linker(collector).model()
        collector.release()
        return model
