"""Texts of a review as Markdown: nothing in them is markup, and places lead to their lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from urllib.parse import quote

from tracerisk.common.text.printable import one_line
from tracerisk.errors import Location
from tracerisk.prm.review.risk_diff import Review, RiskDiff

_SPECIAL = re.compile(r"([\\`*_\[\]<>|~])")
_FIRST = re.compile(r"^(?=[-+#=]|\d+[.)])")
_REFERENCE = re.compile(r"([#!%$])(?=\w)")
_CODE = re.compile(r"`(tracerisk [^`|]*[^`|\s]|[A-Za-z_]\w*)`")
_NOTHING = "\u200b"  # a space without width: what it parts is no reference and no address


def escaped(text: str) -> str:
    """Keep names and reasons from being read as Markdown, HTML, a mention or a cell's end.

    Nor are they references to issues or merge requests, addresses, or commands of a bot. Commands
    of ours, and single words between backticks, are code.
    """
    plain = one_line(text)
    parts = _CODE.split(plain)
    # Every second part is code, in which nothing is markup.
    shown = "".join(f"`{part}`" if i % 2 else _plain(part) for i, part in enumerate(parts))
    return _FIRST.sub(r"\\", shown)


def in_html(text: str) -> str:
    """Return a text as it stands in a tag of HTML, where no Markdown is read but references are."""
    plain = one_line(text).replace("&", "&amp;")
    return _unreferring(plain.replace("<", "&lt;").replace(">", "&gt;"))


def _plain(text: str) -> str:
    return _unreferring(_SPECIAL.sub(r"\\\1", text.replace("&", "&amp;")))


def _unreferring(text: str) -> str:
    apart = _REFERENCE.sub(rf"\1{_NOTHING}", text)
    apart = apart.replace("://", f":{_NOTHING}//").replace("www.", f"www{_NOTHING}.")
    return apart.replace("@", f"@{_NOTHING}")


class Links:
    """Writes the texts of a review with links from places to the lines of its commits."""

    def __init__(self, review: Review, base: str | None) -> None:
        """Take the address that a commit, a path and a line follow; without it none is linked."""
        self._review = review
        self._base = None if base is None else base.rstrip("/")
        files = sorted(set(_files(review)), key=lambda file: (-len(file), file))
        prefix = "|".join(re.escape(text) for text in review.prefixes if text)
        names = "|".join(map(re.escape, files))
        is_linked = self._base is not None and bool(files)
        pattern = rf"(?<![\w./-])({prefix})?({names}):(\d+)(?::\d+)?(?![\w-])"
        self._places = re.compile(pattern) if is_linked else None

    def text(self, text: str, *, is_gone: bool = False) -> str:
        """Return a text, escaped, whose places are links; `is_gone` for places of the earlier one.

        A place of the working tree is none.
        """
        if self._places is None:
            return escaped(text)
        parts, end = [], 0
        for found in self._places.finditer(text):
            parts.append(_kept(text[end : found.start()]))
            address = self._address(found[1], found[2], int(found[3]), is_gone=is_gone)
            # The address says of which commit it is.
            is_later = found[1] is not None and found[1] == self._review.prefixes[1]
            shown = escaped(found[0].removeprefix(found[1]) if address and is_later else found[0])
            parts.append(f"[{shown}]({address})" if address else shown)
            end = found.end()
        return "".join([*parts, _kept(text[end:])]).strip()

    def file(self, shown: str, name: str) -> str:
        """Return a text that names a file, as a link to it."""
        address = self._address(None, name, None, is_gone=False)
        return f"[{escaped(shown)}]({address})" if address else escaped(shown)

    def _address(
        self, prefix: str | None, file: str, line: int | None, *, is_gone: bool
    ) -> str | None:
        review = self._review
        is_before = is_gone or (bool(prefix) and prefix == review.prefixes[0])
        commit, path = review.commits[0 if is_before else 1], review.path(Location(file))
        if self._base is None or commit is None or path is None:
            return None
        of_line = "" if line is None else f"#L{line}"
        name = quote(path, safe="/", errors="surrogateescape")
        return f"{self._base}/{commit}/{name}{of_line}"


def _kept(text: str) -> str:
    """Return a part of a text, escaped, with the spaces at its ends."""
    inner = escaped(text)
    if not inner:
        return " " if text else ""
    return f"{' ' * text[0].isspace()}{inner}{' ' * text[-1].isspace()}"


def _files(review: Review) -> Iterator[str]:
    for diff in review.controllers:
        yield from (name for name in (diff.name, diff.was, diff.hardware_file) if name)
        yield from (place.file for place in _locations(diff))


def _locations(diff: RiskDiff) -> Iterator[Location]:
    fields = (field for change in diff.changes for field in change.fields)
    places = [*(field.location for field in fields), *(pin.location for pin in diff.pins)]
    places += [check.location for check in diff.checks]
    if diff.verdicts is not None:
        for verdict in (diff.verdicts.before, diff.verdicts.after):
            if verdict is not None:
                places += [reason.location for reason in verdict.reasons]
                places += [Location(uncovered.ref.file) for uncovered in verdict.coverage.never_ran]
    yield from (place for place in places if place is not None)
