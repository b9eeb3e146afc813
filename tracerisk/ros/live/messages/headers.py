"""C++ headers that a machine lacks: of messages, made by gencpp from our texts, and of MoveIt."""

from __future__ import annotations

import importlib
import json
import os
import re
import sys
import tempfile
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import DependencyError
from tracerisk.instrument.source.c_tokens import names_included
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.ros.live.loopback import loopback_environment
from tracerisk.ros.live.messages.texts import write_texts
from tracerisk.ros.live.real_ros import python_of_ros, start

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros1 import Interfaces

_OF_MESSAGE = re.compile(rb"(\w+)/(\w+)\.h")
_HERE = Path(__file__).parent
_MOVEIT = ("moveit", "moveit_visual_tools")
"""The folders of what stands for MoveIt's headers where they are missing."""
_OF_ROS = "moveit/of_ros/of_ros"
"""The one of them that differs between the versions of ROS, whose number ends its name here."""
_NO_GENCPP = 3
"""The code with which the generator ends where there is no gencpp."""


def include_folders(environment: Mapping[str, str]) -> tuple[Path, ...]:
    """Return the folders in which a compiler or a build of ROS finds headers."""
    listed = [
        Path(name)
        for variable in ("CPATH", "CPLUS_INCLUDE_PATH")
        for name in environment.get(variable, "").split(os.pathsep)
        if name
    ]
    built = [
        Path(name, "include")
        for variable in ("CMAKE_PREFIX_PATH", "AMENT_PREFIX_PATH")
        for name in environment.get(variable, "").split(os.pathsep)
        if name
    ]
    ros = sorted(Path("/opt/ros").glob("*/include"))
    return (*listed, *built, *ros, Path("/usr/include"), Path("/usr/local/include"))


def make_headers(
    interfaces: Interfaces,
    sources: Iterable[bytes],
    out: Path,
    folders: Collection[Path],
    ros: RosVersion = 1,
) -> tuple[str, ...]:
    """Make below `out` the headers that sources include and none of the folders holds.

    Headers of all that they are made of are made too, where their package is missing; so are those
    of MoveIt's interfaces, which are all that is made for ROS 2. Return the packages, sorted.

    Raises:
        DependencyError: there is no ROS 1, or no gencpp.
    """
    messages: set[str] = set()
    services: set[str] = set()
    sources = list(sources)
    of_moveit = {} if _has_moveit(folders) else _moveit_headers(sources, ros)
    for name, content in of_moveit.items():
        place = out / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    if ros == 2:
        return ("moveit",) if of_moveit else ()
    sources += of_moveit.values()
    for source in sources:
        for header in filter(None, map(_OF_MESSAGE.fullmatch, names_included(source))):
            package, short = (part.decode() for part in header.groups())
            if package not in interfaces.packages or _has(package, folders):
                continue
            if short in interfaces.service_names(package):
                services.add(f"{package}/{short}")
            elif short in interfaces.message_names(package):
                messages.add(f"{package}/{short}")
    if not messages and not services:
        return ()
    with tempfile.TemporaryDirectory(prefix="tracerisk-") as texts:
        packages = write_texts(interfaces, messages, services, Path(texts))
        packages |= {name.split("/")[0] for name in services}
        missing = [name for name in sorted(packages) if not _has(name, folders)]
        asked = json.dumps([texts, str(out), missing])
        environment = loopback_environment(os.environ)
        made = start(__name__, asked, environment=environment, pass_fds=()).wait()
    if made == _NO_GENCPP:
        raise DependencyError(
            f"gencpp makes C++ headers of messages, and {python_of_ros()} has none. On Debian and "
            "Ubuntu: apt install python3-gencpp"
        )
    if made != 0:
        raise DependencyError(f"gencpp could not make the headers of {', '.join(missing)}")
    return tuple(sorted([*missing, *(["moveit"] if of_moveit else [])]))


def _moveit_headers(sources: Iterable[bytes], ros: RosVersion) -> dict[str, bytes]:
    """Return our headers for MoveIt by their names, if the sources include one of them.

    MoveIt 2 gives each of them two names: `.h`, and since Jazzy `.hpp`.
    """
    headers: dict[str, bytes] = {}
    for path in sorted(path for folder in _MOVEIT for path in (_HERE / folder).rglob("*.h")):
        name = path.relative_to(_HERE).as_posix()
        if not name.startswith(_OF_ROS):
            headers[name] = file_bytes(path)
    if ros == 2:
        headers |= {f"{name}pp": b"#include <%s>\n" % name.encode() for name in headers}
    included = {name for source in sources for name in names_included(source)}
    if not any(name.encode() in included for name in headers):
        return {}
    return {f"{_OF_ROS}.h": file_bytes(_HERE / f"{_OF_ROS}{ros}.h"), **headers}


def _has_moveit(folders: Collection[Path]) -> bool:
    """Return whether MoveIt is there; in ROS 2 each package has a folder of its own for headers."""
    return _has("moveit", folders) or any(
        any(folder.glob("*/moveit/move_group_interface")) for folder in folders
    )


def _has(package: str, folders: Collection[Path]) -> bool:
    return any((folder / package).is_dir() for folder in folders)


def main() -> None:
    """Generate the headers; runs under the Python of ROS, with three values in JSON."""
    texts, out, packages = json.loads(sys.argv[1])
    sys.path.append("/opt/ros/noetic/lib/python3/dist-packages")
    try:
        tools: Any = importlib.import_module("genmsg.template_tools")
        importlib.import_module("gencpp")
    except ImportError:
        sys.exit(_NO_GENCPP)
    shares = (Path("/opt/ros/noetic/share/gencpp"), Path("/usr/share/gencpp"))
    templates = next((share for share in shares if share.is_dir()), None)
    if templates is None:
        sys.exit(_NO_GENCPP)
    search = [
        f"{path.name}:{path / 'msg'}" for path in Path(texts).iterdir() if (path / "msg").is_dir()
    ]
    for package in packages:
        place = Path(out, package)
        place.mkdir(parents=True, exist_ok=True)
        for kind in ("msg", "srv"):
            for file in sorted(Path(texts, package, kind).glob(f"*.{kind}")):
                tools.generate_from_file(
                    str(file),
                    package,
                    str(place),
                    str(templates),
                    search,
                    {"msg.h.template": "@NAME@.h"},
                    {"srv.h.template": "@NAME@.h"},
                )


if __name__ == "__main__":
    main()
