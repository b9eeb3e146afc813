"""The import finder that serves stand-ins for ROS libraries and message packages.

It goes first in `sys.meta_path`, so that the stand-ins win over an installed ROS, and it leaves
every name it does not provide to Python. Some stand-ins give way to the author's own source
(`vendor_libraries`). A second finder at the end of the path turns the failed import of what looks
like a ROS package into an error that says what to do.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from difflib import get_close_matches
from dis import opmap
from functools import cache, cached_property, partial
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import CodeType, FrameType, MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from tracerisk.errors import InputError
from tracerisk.ros.graph.runtime import running
from tracerisk.ros.imports.cfg_modules import cfg_module
from tracerisk.ros.imports.compiled_modules import compiled_module
from tracerisk.ros.imports.vendor_libraries import (
    FROM_INDEX,
    VENDOR_LIBRARIES,
    is_installed,
    missing_module,
)
from tracerisk.ros.messages.ros1 import Interfaces

if TYPE_CHECKING:
    from typing_extensions import Self

    from tracerisk.ros.messages.ros2 import Interfaces2

Provided = Literal["library", "interfaces", "library and interfaces"]

STAND_INS = Path(__file__).parents[1] / "stand_ins"
# Packages that are used for their code; their messages alone would be a half of them.
_CODE_WITH_INTERFACES = frozenset(
    {"actionlib", "bond", "dynamic_reconfigure", "roscpp", "sound_play"}
)


def _is_from_import() -> bool:
    """Return whether a statement imports, and no call of `__import__`."""
    frame = _importing()
    return frame is None or frame.f_code.co_code[frame.f_lasti] == opmap["IMPORT_NAME"]


def _is_by_stand_in() -> bool:
    """Return whether a stand-in imports for itself: how long it takes is known as a whole."""
    frame = _importing()
    return frame is not None and frame.f_code.co_filename.startswith(str(STAND_INS))


def _importing() -> FrameType | None:
    """Return the frame that imports, `None` where there is none."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith((__file__, "<frozen")):
        frame = frame.f_back
    return frame


class StandInFinder(MetaPathFinder):
    """Serve the stand-in libraries and the message packages of `interfaces`.

    Those of `giving_way` are served where neither the workspace nor the environment has a library
    of that name. As a context manager it is installed within the block; leaving it takes every
    module that it served out of `sys.modules` and puts back what stood there before.
    """

    def __init__(
        self,
        interfaces: Interfaces | Interfaces2 | None = None,
        giving_way: Collection[str] = VENDOR_LIBRARIES,
    ) -> None:
        self.interfaces = interfaces if interfaces is not None else Interfaces()
        self._giving_way = frozenset(giving_way)
        self._missing = _MissingRosFinder(self)
        self.in_vain: set[str] = set()
        """The top names of what looks like a robot's and was imported in vain."""
        self._shadowed: dict[str, ModuleType] = {}

    @cached_property
    def provides(self) -> Mapping[str, Provided]:
        """What can be imported: the top name of each library and message package, sorted."""
        libraries = {path.name for path in STAND_INS.iterdir() if (path / "__init__.py").is_file()}
        packages = set(self.interfaces.packages) - (_CODE_WITH_INTERFACES - libraries)
        table: dict[str, Provided] = {}
        for name in sorted(libraries | packages):
            if name in libraries and name in packages:
                table[name] = "library and interfaces"
            else:
                table[name] = "library" if name in libraries else "interfaces"
        return MappingProxyType(table)

    def install(self) -> None:
        """Put the finder first on the path; modules it shadows are set aside."""
        if self in sys.meta_path:
            return
        self._shadowed = self._take_out_provided()
        sys.meta_path.insert(0, self)
        sys.meta_path.append(self._missing)

    def uninstall(self) -> None:
        """Undo `install`."""
        if self not in sys.meta_path:
            return
        sys.meta_path.remove(self)
        sys.meta_path.remove(self._missing)
        self._take_out_provided()
        sys.modules.update(self._shadowed)
        self._shadowed = {}

    def __enter__(self) -> Self:
        self.install()
        return self

    def __exit__(self, *error: object) -> None:
        self.uninstall()

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,  # noqa: ARG002
    ) -> ModuleSpec | None:
        """Return the spec of a module that is provided, else None.

        Raises:
            ModuleNotFoundError: a provided library has no such module or name.
        """
        top, _, rest = fullname.partition(".")
        if top not in self.provides:
            return None
        gives_way = top in self._giving_way and self._is_elsewhere(top)
        spec = None if gives_way else self._library_spec(fullname)
        if spec is None and self.provides[top] != "library" and not (gives_way and not rest):
            spec = self._interface_spec(fullname, top, rest)
        if spec is None and not gives_way:
            spec = cfg_module(fullname, path or self._own_folder(top))
        if spec is None and not gives_way:
            raise self._no_such_name(fullname)
        return spec

    def _own_folder(self, top: str) -> list[str]:
        if not isinstance(self.interfaces, Interfaces):
            return []
        folder = self.interfaces.workspace.get(top)
        return [] if folder is None else [str(folder)]

    @staticmethod
    def _is_elsewhere(top: str) -> bool:
        """Return whether the workspace or the environment has a library of its own."""
        loaded = sys.modules.get(top)
        if loaded is None:
            return is_installed(top)
        return not isinstance(getattr(loaded.__spec__, "loader", None), _StandInLoader)

    def _library_spec(self, fullname: str) -> ModuleSpec | None:
        row = _file_and_folder(fullname)
        if row is None:
            return None
        file, folder = row
        return spec_from_file_location(
            fullname,
            file,
            loader=_StandInLoader(fullname, file),
            submodule_search_locations=None if folder is None else [folder],
        )

    def _interface_spec(self, fullname: str, package: str, rest: str) -> ModuleSpec | None:
        kind, _, leaf = rest.partition(".")
        if not rest:
            kinds = self.interfaces.kinds
            served = [name for name in kinds if self._has(package, name)]
            loader = _InterfaceLoader(partial(_package, kinds=served))
            return ModuleSpec(fullname, loader, is_package=True)
        if kind not in self.interfaces.kinds:
            return None
        # Generated packages hold `msg/_Pose.py`, and editors write imports of it.
        if leaf and leaf not in self.interfaces.modules(package, kind):
            return None
        make = _InterfaceModule.maker(self.interfaces, package, kind)
        return ModuleSpec(fullname, _InterfaceLoader(make), is_package=True)

    def _has(self, package: str, kind: str) -> bool:
        return bool(self.interfaces.module_names(package, kind))

    def _no_such_name(self, fullname: str) -> ModuleNotFoundError:
        # `from rospy import nope` comes here as a module `rospy.nope`. An error that carries
        # that name is swallowed by the import system; one that carries the library's is not.
        parent, _, leaf = fullname.rpartition(".")
        known = sys.modules.get(parent)
        names = public_names(known) if known is not None else []
        if not _is_from_import():
            # `__import__` with a list of names takes what is there of them.
            return ModuleNotFoundError(missing_name(parent, leaf, names), name=fullname)
        return ModuleNotFoundError(missing_name(parent, leaf, names), name=parent)

    def _take_out_provided(self) -> dict[str, ModuleType]:
        ours = self.provides.keys() | FROM_INDEX
        names = [name for name in list(sys.modules) if name.partition(".")[0] in ours]
        return {name: sys.modules.pop(name) for name in names}


class _MissingRosFinder(MetaPathFinder):
    """The last finder: it knows nothing, but says more about what looks like a robot's."""

    def __init__(self, stand_ins: StandInFinder) -> None:
        self._stand_ins = stand_ins

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,  # noqa: ARG002
    ) -> ModuleSpec | None:
        if path is not None:
            if fullname.startswith("pymoveit2.robots."):
                from tracerisk.ros.imports.pymoveit2_releases import robot_of_a_fork

                return robot_of_a_fork(fullname)
            return cfg_module(fullname, path) or compiled_module(fullname, path)
        message = missing_module(fullname, self._stand_ins.provides)
        if message is not None:
            self._stand_ins.in_vain.add(fullname)
            raise ModuleNotFoundError(message, name=fullname)
        return None


class _StandInLoader(SourceFileLoader):
    """Load a stand-in from its file; a name it lacks is an error that says so.

    A module of a package is there when it is read: which import of the real library brings which
    other with it (`rclpy.node` comes with `rclpy.action`) is not for a stand-in to decide.
    """

    _codes: ClassVar[dict[str, CodeType | None]] = {}

    def get_code(self, fullname: str) -> CodeType | None:
        if fullname not in self._codes:
            self._codes[fullname] = super().get_code(fullname)
        return self._codes[fullname]

    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        if "__getattr__" not in vars(module):
            parts = _modules_beside(Path(self.path)) if self.is_package(module.__name__) else ()
            vars(module)["__getattr__"] = _late_attribute(module, parts)
        # With a path, `from library.module import nope` is asked of the finder as well.
        vars(module).setdefault("__path__", [])


def read_stand_ins(*libraries: str) -> None:
    """Read the code of libraries' stand-ins: processes that are forked have it in memory."""
    for file in (path for name in libraries for path in (STAND_INS / name).rglob("*.py")):
        parts = file.relative_to(STAND_INS).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        _file_and_folder(name)
        _StandInLoader(name, str(file)).get_code(name)
        if file.name == "__init__.py":
            _modules_beside(file)


@cache
def _file_and_folder(fullname: str) -> tuple[str, str | None] | None:
    """Return the file of a stand-in's module, and its folder where it is a package."""
    base = STAND_INS.joinpath(*fullname.split("."))
    if (base / "__init__.py").is_file():
        return str(base / "__init__.py"), str(base)
    file = base.with_suffix(".py")
    return (str(file), None) if file.is_file() else None


@cache
def _modules_beside(file: Path) -> frozenset[str]:
    """Return the names of the public modules and packages in a package's folder."""
    return frozenset(
        path.stem
        for path in file.parent.iterdir()
        if not path.name.startswith("_")
        if path.suffix == ".py" or (path / "__init__.py").is_file()
    )


class _InterfaceLoader(Loader):
    def __init__(self, make: Callable[[ModuleSpec], ModuleType]) -> None:
        self._make = make

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return self._make(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Count the time of the import: the module makes its classes when they are asked for."""
        runtime = running()
        if runtime is not None and isinstance(module, _InterfaceModule) and not _is_by_stand_in():
            runtime.graph.carrier.owe("import")


class _InterfaceModule(ModuleType):
    """`<package>.msg`, `.srv` or `.action`: a class is made when its name is first read."""

    _interfaces: Interfaces | Interfaces2
    _package: str
    _kind: str

    @classmethod
    def maker(
        cls, interfaces: Interfaces | Interfaces2, package: str, kind: str
    ) -> Callable[[ModuleSpec], ModuleType]:
        def make(spec: ModuleSpec) -> ModuleType:
            module = cls(spec.name, f"Interfaces of the ROS package {package}.")
            module._interfaces, module._package, module._kind = interfaces, package, kind
            return module

        return make

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return [*self._names, *self._interfaces.star_names(self._package, self._kind)]
        if name.startswith("__"):
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'")
        if name in self._names:
            value = self._make(name)
        elif name in self._interfaces.star_names(self._package, self._kind):
            value = import_module(name)
        else:
            raise AttributeError(missing_name(self.__name__, name, self._names), name=name)
        setattr(self, name, value)
        return value

    def __dir__(self) -> list[str]:
        return sorted({*vars(self), *self._names})

    @cached_property
    def _names(self) -> tuple[str, ...]:
        # Asked for at each name of a package, of which some have hundreds.
        return self._interfaces.module_names(self._package, self._kind)

    def _make(self, name: str) -> Any:
        try:
            return self._interfaces.interface(self._package, self._kind, name)
        except InputError as error:
            # No build makes a module of such a text.
            message = f"{self._package}/{name} cannot be built: {error}"
            raise ModuleNotFoundError(message, name=self.__name__) from error


def _package(spec: ModuleSpec, *, kinds: Sequence[str]) -> ModuleType:
    """Make a package whose modules are there when they are read.

    In a real ROS `import sensor_msgs` is enough where anything else has imported
    `sensor_msgs.msg`, as the code of most other messages has.
    """
    module = ModuleType(spec.name, f"The ROS package {spec.name}.")
    vars(module)["__getattr__"] = _late_attribute(module, kinds)
    return module


def _late_attribute(module: ModuleType, parts: Collection[str]) -> Callable[[str], Any]:
    """Return what gives a module its `parts` as they are read; what else it lacks is an error."""

    def getattribute(name: str) -> Any:
        if name in parts:
            return import_module(f"{module.__name__}.{name}")
        if name.startswith("__"):
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        names = public_names(module)
        raise AttributeError(missing_name(module.__name__, name, names), name=name)

    return getattribute


def public_names(module: ModuleType) -> list[str]:
    """Return the public names of a module, sorted; no modules it has imported."""
    return sorted(
        name
        for name in dir(module)
        if not name.startswith("_") and not isinstance(vars(module).get(name), ModuleType)
    )


def missing_name(library: str, name: str, names: Sequence[str]) -> str:
    """Explain that the stand-in for `library` lacks `name`, and what it has that is near."""
    near = get_close_matches(name, names, n=3)
    hint = f"nearest: {', '.join(near)}" if near else "it has nothing of a similar name"
    return (
        f"{library} has no '{name}' in tracerisk's stand-in for it; {hint}. "
        f"If the real library has it, it is not provided yet"
    )
