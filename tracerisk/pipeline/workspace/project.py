"""The project of controllers: the packages around it, its settings, its lock, its sources."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, Lock
from tracerisk.adder.lock.reading import read_lock
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.common.settings.settings_file import SettingOrigin
from tracerisk.config import Settings, controller_root

TYPE_CHECKING = False
if TYPE_CHECKING:
    import ast
    from collections.abc import Mapping

    from tracerisk.instrument.source.ros_version import RosVersion
    from tracerisk.pipeline.workspace.prefixes import Prefix
    from tracerisk.pipeline.workspace.workspace import Workspace


class Project:
    """What belongs to the controllers of one root, as it was when it was first asked for.

    Each part is read on its first use and kept. Who must see what was written since makes a new
    project, or asks `Projects`.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        """The folder that holds the controllers' own sources."""
        self._workspaces: dict[RosVersion | None, Workspace] = {}
        self._prefixes: dict[object, tuple[Prefix, ...]] = {}
        self._ros: dict[Path, RosVersion] = {}
        self._trees: dict[bytes, ast.Module | None] = {}
        self._imports: dict[bytes, tuple[tuple[int, tuple[str, ...]], ...]] = {}

    @classmethod
    def of(cls, path: Path) -> Project:
        """Return the project that a file belongs to."""
        return cls(controller_root(path))

    def __reduce__(self) -> tuple[type[Project], tuple[Path]]:
        # Another process reads for itself: that is quicker than to send trees.
        return Project, (self.root,)

    @cached_property
    def top(self) -> Path:
        """The folder whose files belong to one project with the root: often a repository."""
        # Blocks are checked without the packages around them.
        from tracerisk.pipeline.workspace.workspace import project_top

        return project_top(self.root)

    def workspace(self, ros: RosVersion | None = None) -> Workspace:
        """Return the packages of the project, and of its workspace; no installed ones.

        Of several with one name it is that for the given ROS; without, for that of the root's own.
        """
        from tracerisk.pipeline.workspace.workspace import find_workspace

        if ros not in self._workspaces:
            self._workspaces[ros] = find_workspace(self.root, self.top, ros)
        return self._workspaces[ros]

    def ros_version(self, script: Path) -> RosVersion:
        """Return for which ROS a script of the project is written."""
        script = script.resolve()
        if script not in self._ros:
            from tracerisk.instrument.source.ros_version import ros_version

            self._ros[script] = ros_version(script, self.root.resolve())
        return self._ros[script]

    def prefixes(self, ros: RosVersion, settings: Settings) -> tuple[Prefix, ...]:
        """Return where packages are installed for controllers of one ROS, the first to count first.

        `settings` are those of the controller, which may name prefixes and a distribution.
        """
        from tracerisk.pipeline.workspace.prefixes import find_prefixes

        key = (ros, settings.ros_prefixes, settings.ros_distro)
        if key not in self._prefixes:
            named, distro = settings.ros_prefixes, settings.ros_distro
            self._prefixes[key] = find_prefixes(self.root, self.top, ros, named, distro)
        return self._prefixes[key]

    @cached_property
    def lock(self) -> Lock:
        """The lock in the root; an empty one where there is none.

        Raises LockError where it is malformed.
        """
        return read_lock(self.root / LOCK_NAME)

    @cached_property
    def _settings(self) -> ProjectSettings:
        return ProjectSettings(self.root)

    def settings(self, file: str | None = None) -> Settings:
        """Return the settings of a controller, named from the root; without, those of all.

        Raises SettingsError as `ProjectSettings.of`.
        """
        return self._settings.of(file)

    def setting_origins(self, file: str) -> Mapping[str, SettingOrigin]:
        """Return where each setting of a controller comes from. Raises as `settings`."""
        return self._settings.origins(file)

    @property
    def controllers_with_settings(self) -> tuple[str, ...]:
        """The controllers that have settings of their own in the file of all."""
        return self._settings.controllers

    def tree(self, source: bytes) -> ast.Module | None:
        """Return the tree of a source, which nobody may change; `None` where it cannot be read."""
        if source not in self._trees:
            from tracerisk.instrument.source.python_source import parsed

            self._trees[source] = parsed(source)
        return self._trees[source]

    def imports(self, source: bytes) -> tuple[tuple[int, tuple[str, ...]], ...]:
        """Return what a source imports, as `imports_in`; nothing where it cannot be read."""
        if source not in self._imports:
            from tracerisk.instrument.source.dotted_names import imports_in

            self._imports[source] = imports_in(self.tree(source))
        return self._imports[source]


class Projects:
    """The projects of files, each read once until its settings or its lock change."""

    def __init__(self) -> None:
        self._known: dict[Path, tuple[object, Project]] = {}  # each with the version of its files

    def __reduce__(self) -> tuple[type[Projects], tuple[()]]:
        return Projects, ()

    def of(self, path: Path) -> Project:
        """Return the project that a file belongs to, as its files are now."""
        return self.at(controller_root(path))

    def at(self, root: Path) -> Project:
        """Return the project in a root, as its files are now."""
        root = root.resolve()
        version = tuple(file_version(root / name) for name in (LOCK_NAME, "pyproject.toml"))
        known = self._known.get(root)
        if known is None or known[0] != version:
            known = self._known[root] = version, Project(root)
        return known[1]


def file_version(path: Path) -> tuple[int, ...] | None:
    """Return what differs between two versions of a file; `None` where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return (status.st_dev, status.st_ino, status.st_mtime_ns, status.st_size)
