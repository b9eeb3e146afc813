"""Put entries into the text of a scenario, every other byte of which stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.yaml_reader import YamlMap, read_yaml
from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.parameter_files import plain
from tracerisk.ros.scenario.file.lines import plain_lines, sections_text


def with_entries(
    base: Path | None, sections: Mapping[str, Sequence[str]], remarks: Sequence[str] = ()
) -> str:
    """Return the text of the scenario `base` with the lines of more entries in its sections.

    A section that is written in brackets is written anew, line by line. `remarks` are comments.
    Raises ScenarioError where the base cannot be read.
    """
    if base is None:
        return sections_text(sections, remarks)
    raw = file_bytes(base).decode("utf-8-sig")
    newline = "\r\n" if "\r\n" in raw else "\n"
    lines = raw.splitlines()
    if not any(line.strip() and not line.strip().startswith("#") for line in lines):
        return newline.join([*lines, *sections_text(sections, remarks).splitlines(), ""])
    top = read_yaml(base, ScenarioError)
    absent: dict[str, Sequence[str]] = {}
    starts = sorted((top.key_location(key).line or 1) - 1 for key in top.keys())  # noqa: SIM118
    # From the end on, so that the places before stay.
    known = [name for name in sections if sections[name] and name in top]
    known.sort(key=lambda name: top.key_location(name).line or 0, reverse=True)
    for name in known:
        start = (top.key_location(name).line or 1) - 1
        end = next((number for number in starts if number > start), len(lines))
        while end > start + 1 and _is_empty(lines[end - 1]):
            end -= 1
        lines[start:end] = _section(top, name, lines[start:end], sections[name])
    absent = {name: section for name, section in sections.items() if name not in top}
    reported = [remark for remark in remarks if remark not in lines]
    more = sections_text(absent, reported).splitlines()
    return newline.join([*lines, *more, ""])


def _is_empty(line: str) -> bool:
    return not line.strip() or line.startswith("#")


def _section(top: YamlMap, name: str, lines: list[str], more: Sequence[str]) -> list[str]:
    if name == "robot":
        return lines
    value = top.get(name)
    flow = getattr(value, "fa", None)
    if not value or flow is None or flow.flow_style():
        return [f"{name}:", *plain_lines(plain(value) if value else []), *more]
    if isinstance(value, dict):
        first = top.map(name).keys()[0]
        indent = (top.map(name).key_location(first).column or 1) - 1
    else:
        first_line = (top.entry_location(name, 0).line or 1) - (top.key_location(name).line or 1)
        dash = lines[first_line] if 0 <= first_line < len(lines) else ""
        indent = len(dash) - len(dash.lstrip())
    return [*lines, *(f"{' ' * indent}{line[2:]}" for line in more)]
