"""What a process that runs a stranger's code may take and reach, as plain data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.config import SandboxMode

_MB = 1024 * 1024
# What people keep beside their sources and no controller needs.
_SECRET_ENDINGS = (".key", ".pem", ".p12", ".pfx")
_SECRET_NAMES = ("id_rsa", "id_dsa", "id_ecdsa", "id_ed25519", "credentials.json")
# Hidden files that libraries of ROS read. They hold names and paths of a workspace alone.
# moveit/moveit2 moveit_configs_utils/moveit_configs_utils/moveit_configs_builder.py,
# ros/catkin python/catkin/workspace.py, colcon/colcon-core colcon_core/location.py
_READ_BY_ROS = (".setup_assistant", ".catkin", ".colcon_install_layout")


@dataclass(frozen=True, slots=True)
class Sandbox:
    """How strangers' code is contained."""

    mode: SandboxMode = "auto"
    """Whether the sandbox is used where it works, always or never."""
    readable: tuple[str, ...] = ()
    """The files and folders that it may read besides the defaults."""
    writable: tuple[str, ...] = ()
    """The files and folders that it may write besides the defaults."""
    env: tuple[str, ...] = ()
    """The names of environment variables that it gets besides the defaults."""


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit, and the setting of `[tool.tracerisk]` that raises it."""

    setting: str
    """The name of the setting."""
    value: float
    """Its value, in the unit at the end of its name."""

    @property
    def advice(self) -> str:
        """How to raise the limit: option and setting with its value."""
        option = self.setting.rpartition("_")[0].replace("_", "-")
        return f"raise it with --{option} or the setting {self.setting} (now {self.value:g})"


@dataclass(frozen=True, slots=True)
class Limits:
    """What a process that reads a file or draws may take; the defaults are those of `Settings`."""

    own: Limit = Limit("stall_limit_s", 30.0)
    """Time that it computes or sleeps [s]."""
    wall: Limit = Limit("wall_limit_s", 1800.0)
    """Wall time [s]."""
    memory: Limit = Limit("memory_limit_mb", 8192)
    """Address space of a controller [MB]; a process that reads a file has a quarter of it."""
    sandbox: Sandbox = field(default_factory=Sandbox)
    """What else the process may reach."""

    @property
    def memory_bytes(self) -> int:
        """The address space of a process that reads a file [bytes]."""
        return max(1, int(self.memory.value)) * _MB // 4


DEFAULT_LIMITS = Limits()
"""The limits where no settings are at hand."""


def is_secret(name: str) -> bool:
    """Return whether a name is that of what no controller reads: `.git`, `.env`, a key.

    Any hidden name is, but for those of the few files that libraries of ROS read.
    """
    if name in _READ_BY_ROS:
        return False
    return name.startswith(".") or name in _SECRET_NAMES or name.endswith(_SECRET_ENDINGS)
