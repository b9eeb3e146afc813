"""Where an editor folds risk blocks: each as a whole, and each of its sections."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lsprotocol.types import FoldingRange, FoldingRangeKind

from tracerisk.editor.outline import Outline

_OPENS = re.compile(r"@\w+\s*(?::=\s*(?:omit\s*)?)?\{")


def foldings(outline: Outline, lines: Sequence[str]) -> Iterator[FoldingRange]:
    """Yield the ranges of a source's blocks; `lines` are its lines as they are now."""
    for placed in outline.placed:
        first, last = placed.first_line - 1, placed.last_line - 1
        if last >= len(lines):
            continue
        name = placed.block.name
        yield FoldingRange(
            first, last, kind=FoldingRangeKind.Region, collapsed_text=f"RiskAnnotation {name}"
        )
        begun = None
        for number in range(first, last + 1):
            text = lines[number].rstrip()
            if _OPENS.search(text):
                begun = number
            elif text.endswith("}") and begun is not None:
                if number > begun:
                    yield FoldingRange(begun, number, kind=FoldingRangeKind.Region)
                begun = None
