"""Python modules of message packages that the installed ROS lacks, made by genpy from our texts."""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.errors import DependencyError
from tracerisk.ros.live.loopback import loopback_environment
from tracerisk.ros.live.real_ros import python_of_ros, start

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros1 import Interfaces

_IMPORT = re.compile(rb"^\s*(?:from|import)\s+(\w+)\.?(\w*)", re.MULTILINE)
_WORD = re.compile(rb"\w+")
_PARTS = re.compile(r"(Action)?(Goal|Result|Feedback|Request|Response)?$")


def make_missing_modules(interfaces: Interfaces, sources: Iterable[bytes], folder: Path) -> bool:
    """Make in `folder` the modules that sources import and ROS lacks; return whether any are.

    Of each package those messages and services are made whose names the sources hold, with all
    that these are made of.

    Raises:
        DependencyError: there is no ROS, or its genpy fails.
    """
    texts = list(sources)
    named = {match_.group(1).decode() for text in texts for match_ in _IMPORT.finditer(text)}
    wanted = sorted(named & set(interfaces.packages))
    missing = _missing(wanted)
    if not missing:
        return False
    words = {item.decode() for text in texts for item in _WORD.findall(text)}
    messages: set[str] = set()
    services: set[str] = set()
    for package in missing:
        for name in interfaces.message_names(package):
            if words & {name, _PARTS.sub("", name), _PARTS.sub("", name) + "Action"}:
                messages.add(f"{package}/{name}")
        services |= {f"{package}/{n}" for n in interfaces.service_names(package) if n in words}
    texts_folder = folder / "texts"
    closure = _with_parts(interfaces, messages, services)
    for name in closure:
        package, short = name.split("/")
        _write(texts_folder / package / "msg" / f"{short}.msg", _text(interfaces, name))
    for name in services:
        package, short = name.split("/")
        request, response = (_text(interfaces, name + part) for part in ("Request", "Response"))
        _write(texts_folder / package / "srv" / f"{short}.srv", f"{request}---\n{response}")
    also = _missing({word.split("/")[0] for word in closure})
    asked = json.dumps([str(texts_folder), str(folder), sorted({*missing, *also})])
    made = start(
        "tracerisk.ros.live.message_modules",
        asked,
        environment=loopback_environment(os.environ),
        pass_fds=(),
    )
    if made.wait() != 0:
        raise DependencyError(
            f"genpy of {python_of_ros()} could not make the modules of {', '.join(missing)}"
        )
    return True


def main() -> None:
    """Generate the modules; runs under the Python of ROS, with three values in JSON."""
    texts, out, packages = json.loads(sys.argv[1])
    generator: Any = importlib.import_module("genpy.generator")
    search = {
        path.name: [str(path / "msg")] for path in Path(texts).iterdir() if (path / "msg").is_dir()
    }
    for package in packages:
        for kind, make in (("msg", generator.MsgGenerator), ("srv", generator.SrvGenerator)):
            files = sorted(map(str, Path(texts, package, kind).glob(f"*.{kind}")))
            place = Path(out, package, kind)
            place.mkdir(parents=True, exist_ok=True)
            Path(out, package, "__init__.py").touch()
            if files and make().generate_messages(package, files, str(place), search):
                sys.exit(1)
            names = [Path(file).stem for file in files]
            lines = "".join(f"from ._{name} import *\n" for name in names)
            Path(place, "__init__.py").write_text(lines, encoding="utf-8")


def _missing(packages: Iterable[str]) -> list[str]:
    """Return those of the packages that the Python of ROS lacks, sorted."""
    code = (
        "import importlib.util as u, json, sys; "
        "print(json.dumps([n for n in json.loads(sys.argv[1]) if u.find_spec(n) is None]))"
    )
    asked = json.dumps(sorted(packages))
    done = subprocess.run(
        [python_of_ros(), "-s", "-c", code, asked],
        capture_output=True,
        text=True,
        check=True,
        cwd="/",
        env=loopback_environment(os.environ),
    )
    loads: list[str] = json.loads(done.stdout)
    return loads


def _with_parts(interfaces: Interfaces, messages: set[str], services: set[str]) -> list[str]:
    waiting = sorted(messages)
    parts = [f"{name}{part}" for name in sorted(services) for part in ("Request", "Response")]
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


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
