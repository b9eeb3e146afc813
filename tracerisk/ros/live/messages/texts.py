"""The texts of messages and services as files that the generators of ROS 1 read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros1 import Interfaces


def write_texts(
    interfaces: Interfaces, messages: Iterable[str], services: Iterable[str], folder: Path
) -> set[str]:
    """Write messages and services into `PACKAGE/msg` and `PACKAGE/srv`, with all of their parts.

    They are named `package/Name`. Return the packages that hold any of the messages.

    Raises:
        InputError: one of them is not known.
    """
    services = sorted(services)
    names = _with_parts(interfaces, messages, services)
    for name in names:
        _write(folder, name, "msg", _text(interfaces, name))
    for name in services:
        request, response = (_text(interfaces, name + part) for part in ("Request", "Response"))
        _write(folder, name, "srv", f"{request}---\n{response}")
    return {name.split("/")[0] for name in names}


def _with_parts(
    interfaces: Interfaces, messages: Iterable[str], services: Iterable[str]
) -> list[str]:
    waiting = sorted(messages)
    parts = [f"{name}{part}" for name in services for part in ("Request", "Response")]
    names: set[str] = set()
    while waiting or parts:
        is_part = not waiting
        name = parts.pop() if is_part else waiting.pop()
        if name in names:
            continue
        if not is_part:
            names.add(name)
        for field in interfaces.message(name)._fields:
            if field.message is not None:
                waiting.append(field.base)
    return sorted(names)


def _text(interfaces: Interfaces, name: str) -> str:
    constants, _ = interfaces._definition(*name.split("/"))
    lines = [f"{kind} {constant}={value}" for constant, kind, value in constants]
    fields = interfaces.message(name)._fields
    lines += [f"{field.type_text} {field.name}" for field in fields]
    return "".join(f"{line}\n" for line in lines)


def _write(folder: Path, name: str, kind: str, text: str) -> None:
    package, short = name.split("/")
    path = folder / package / kind / f"{short}.{kind}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
