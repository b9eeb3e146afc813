"""The text of a scenario: its sections in their order, each entry with its mark."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from tracerisk.ros.drafts.draft import SECTIONS, Draft
from tracerisk.ros.scenario.file.marks import MARK

_WIDTH = 88
_PLAIN = re.compile(r"[A-Za-z/~][\w/.]*")
_NO_STRINGS = frozenset({"true", "false", "null", "yes", "no", "on", "off", "nan", "inf"})
_ORDER = ("robot", "arguments", *dict.fromkeys(SECTIONS.values()), "success")


def scenario_lines(drafts: Iterable[Draft]) -> str:
    """Return the sections of a scenario that meet the needs, each entry marked as assumed.

    What no scenario can give stands in a comment.
    """
    sections: dict[str, list[str]] = {}
    cannot: list[str] = []
    for draft in drafts:
        if draft.value is None:
            cannot.append(f"# {draft.need.words}: {draft.words}")
        else:
            sections.setdefault(draft.section, []).extend(entry_lines(draft))
    return sections_text(sections, cannot)


def sections_text(sections: Mapping[str, Iterable[str]], remarks: Iterable[str] = ()) -> str:
    """Return the text of a scenario's sections, given by the lines of their entries.

    The lines of `robot` hold its name; what `remarks` say stands at the end.
    """
    lines: list[str] = []
    for name in _ORDER:
        inner = tuple(sections.get(name, ()))
        if not inner:
            continue
        lines += [f"{name}: {inner[0]}"] if name == "robot" else [f"{name}:", *inner]
    return "".join(f"{line}\n" for line in (*lines, *remarks))


def entry_lines(draft: Draft) -> list[str]:
    """Return the lines of one entry within its section, the first with the mark."""
    mark = f"{MARK}: {' '.join(draft.words.split())}"
    if draft.section in ("start", "mount"):
        lines = [f"  {_text(name)}: {_flow(item)}" for name, item in draft.value.items()]
    elif draft.section == "parameters":
        lines = _keyed(f"  {_text(draft.key)}:", draft.value, 4)
    elif draft.section == "answers":
        return [f"  - {_flow(str(item))}  {mark}" for item in draft.value]
    else:
        inner = _block(draft.value, 4)
        lines = [f"  - {inner[0].lstrip()}", *inner[1:]]
    return [f"{lines[0]}  {mark}", *lines[1:]]


def plain_lines(value: Any) -> list[str]:
    """Return the lines of a section's content: a mapping, or a list of mappings or texts."""
    if isinstance(value, Mapping):
        return [line for key, item in value.items() for line in _keyed(f"  {_text(key)}:", item, 4)]
    lines: list[str] = []
    for fields in value:
        inner = _block(fields, 4) if isinstance(fields, Mapping) else [_flow(fields)]
        lines += [f"  - {inner[0].lstrip()}", *inner[1:]]
    return lines


def word_lines(words: Iterable[str], remark: str) -> list[str]:
    """Return the lines of a list of words, each with the mark and what is said of it."""
    return [f"  - {_quoted(word)}  {MARK}: {remark}" for word in words]


def marked_entry(value: Mapping[str, Any], remark: str) -> list[str]:
    """Return the lines of an entry of a list, the first with the mark and what is said of it."""
    mark = f"{MARK}: {remark}"
    if len(flow := _flow(value)) <= _WIDTH:
        return [f"  - {flow}  {mark}"]
    first, *more = _block(value, 4)
    return [f"  - {first.lstrip()}  {mark}", *more]


def _block(value: Mapping[str, Any], indent: int) -> list[str]:
    lines = []
    for key, inner in value.items():
        lines += _keyed(f"{' ' * indent}{_text(key)}:", inner, indent + 2)
    return lines


def _keyed(head: str, value: Any, indent: int) -> list[str]:
    flow = _flow(value)
    if len(head) + 1 + len(flow) <= _WIDTH:
        return [f"{head} {flow}"]
    if isinstance(value, dict) and value:
        return [head, *_block(value, indent)]
    if isinstance(value, list) and any(isinstance(item, dict) and item for item in value):
        lines = [head]
        for item in value:
            inner = _block(item, indent + 2)
            lines += [f"{' ' * indent}- {inner[0].lstrip()}", *inner[1:]]
        return lines
    return [f"{head} {flow}"]


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        pairs = ", ".join(f"{_text(str(key))}: {_flow(item)}" for key, item in value.items())
        return f"{{{pairs}}}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if value is None:
        return "null"
    return _text(value) if isinstance(value, str) else _number(value)


def _number(value: Any) -> str:
    text = repr(value)
    # YAML reads `1e-05` as a text.
    return re.sub(r"^(-?\d+)e", r"\1.0e", text)


def _text(text: str) -> str:
    if _PLAIN.fullmatch(text) and text.lower() not in _NO_STRINGS and text != "~":
        return text
    return _quoted(text)


def _quoted(text: str) -> str:
    if any(ord(name) < 32 or ord(name) == 127 for name in text):
        return json.dumps(text)
    return "'" + text.replace("'", "''") + "'"
