"""Write a hardware description as YAML that reads back as the same description."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from tracerisk.common.hardware.description_data import component_data, head_data
from tracerisk.common.hardware.model import Component, Hardware

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./\-]*|10/3")
_WORDS_OF_YAML = frozenset({"true", "false", "null", "yes", "no", "on", "off", "y", "n"})
"""What is not a string where it stands without quotes, in one version of YAML or the other."""
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


def write_hardware(hardware: Hardware) -> str:
    """Return the description as YAML; reading it gives an equal one."""
    lines = list(head_lines(hardware))
    for component in hardware.components:
        lines += component_lines(component)
    return "\n".join(lines) + "\n"


def head_lines(hardware: Hardware) -> Iterator[str]:
    """Yield the lines that stand before the components."""
    for key, value in head_data(hardware).items():
        yield key_line(key, value)
    yield "components:"


def component_lines(component: Component) -> Iterator[str]:
    """Yield the lines of one component, a key a line."""
    yield f"  {_text(component.name)}:"
    for key, value in component_data(component).items():
        yield f"    {key_line(key, value)}"


def key_line(key: str, value: Any) -> str:
    """Return a key with its value, which is plain data, in one line."""
    return f"{key}: {_text(value)}"


def _text(value: Any) -> str:
    """Return a value in one line of YAML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_text(key)}: {_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_text, value)) + "]"
    if isinstance(value, str):
        return _string(value)
    # The fewest digits that read back as the same number.
    return repr(value).removesuffix(".0")


def _string(text: str) -> str:
    """Return a string, in quotes where it needs them."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS_OF_YAML:
        return text
    return '"' + "".join(map(_quoted, text)) + '"'


def _quoted(character: str) -> str:
    if character in _ESCAPES:
        return _ESCAPES[character]
    if character.isprintable():
        return character
    code = ord(character)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
