"""`<package>.cfg.<Name>Config`: what catkin generates from `cfg/<Name>.cfg` of a package.

The file is run when the module is imported, with the stand-in of dynamic_reconfigure's generator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import PACKAGE_FILE

_SUFFIX = "Config"
_DEEPEST = 3  # a module of a package stands at most in `<package>/src/<package>`


def cfg_module(fullname: str, path: Sequence[str]) -> ModuleSpec | None:
    """Return the spec of a package's `cfg`, or of a configuration in it; None for all else.

    `path` is where the module's parent looks for modules.
    """
    _, _, leaf = fullname.rpartition(".")
    if leaf == "cfg":
        folder = _cfg_folder(path)
        if folder is None:
            return None
        spec = ModuleSpec(fullname, FilledLoader(lambda _: {}), is_package=True)
        spec.submodule_search_locations = [str(folder)]
        return spec
    if leaf.endswith(_SUFFIX) and fullname.split(".")[-2:-1] == ["cfg"]:
        for name in path:
            file = Path(name, f"{leaf.removesuffix(_SUFFIX)}.cfg")
            if file.is_file():
                loader = FilledLoader(partial(_generated, file))
                return ModuleSpec(fullname, loader, origin=str(file))
    return None


def _cfg_folder(path: Sequence[str]) -> Path | None:
    for name in path:
        folder = Path(name)
        for above in (folder, *folder.parents[:_DEEPEST]):
            if (above / PACKAGE_FILE).is_file():
                return above / "cfg" if any((above / "cfg").glob("*.cfg")) else None
    return None


class FilledLoader(Loader):
    """Loads a module that `names` gives its names, by that of the module."""

    def __init__(self, names: Callable[[str], Mapping[str, Any]]) -> None:
        self._names = names

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:  # noqa: ARG002
        """Leave it to Python to make the module."""
        return None

    def exec_module(self, module: ModuleType) -> None:
        """Give the module its names."""
        vars(module).update(self._names(module.__name__))


def _generated(file: Path, _: str) -> dict[str, Any]:
    from dynamic_reconfigure.encoding import extract_params
    from dynamic_reconfigure.parameter_generator_catkin import ParameterGenerator

    ParameterGenerator.latest = None
    code = compile(file_bytes(file), str(file), "exec", dont_inherit=True)
    try:
        exec(code, {"__name__": "__main__", "__file__": str(file)})
    except SystemExit as end:
        if end.code not in (None, 0):
            raise ImportError(f"{file}: it ends with status {end.code}") from end
    generator = ParameterGenerator.latest
    if generator is None:
        raise ImportError(f"{file}: it describes nothing: no generator's `generate` was called")
    description = generator.group.to_dict()
    parameters = list(extract_params(description))
    level = 0
    for parameter in parameters:
        level |= parameter["level"]
    return {
        "inf": float("inf"),
        "config_description": description,
        **{
            table: {parameter["name"]: parameter[field] for parameter in parameters}
            for table, field in _tables()
        },
        "all_level": level,
        **{
            f"{file.stem}_{constant['name']}": constant["value"] for constant in generator.constants
        },
    }


def _tables() -> Iterator[tuple[str, str]]:
    yield from (("min", "min"), ("max", "max"), ("defaults", "default"))
    yield from (("level", "level"), ("type", "type"))
