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
from tracerisk.ros.live.messages.texts import write_texts
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
    also = _missing(write_texts(interfaces, messages, services, texts_folder))
    asked = json.dumps([str(texts_folder), str(folder), sorted({*missing, *also})])
    made = start(
        "tracerisk.ros.live.messages.modules",
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


if __name__ == "__main__":
    main()
