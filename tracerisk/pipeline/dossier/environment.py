"""With what a dossier was made: the versions of Python and of the packages, and the processor."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from tracerisk.common.dependencies import MODULES


@dataclass(frozen=True, slots=True)
class Environment:
    """What a figure may depend on beside its files and the version of tracerisk."""

    python: str
    """Version of Python."""
    system: str
    """Name of the operating system, such as `Linux`."""
    processor: str
    """Kind of processor, such as `x86_64`."""
    packages: Mapping[str, str]
    """Version of each installed package that tracerisk uses, by its name, sorted."""

    @property
    def constraints(self) -> str:
        """The versions as a file of constraints for pip."""
        return "".join(f"{name}=={number}\n" for name, number in self.packages.items())

    @property
    def words(self) -> str:
        """What the simulation depends on, in short."""
        named = [f"{name} {self.packages[name]}" for name in _NAMED if name in self.packages]
        return ", ".join((f"Python {self.python}", f"{self.system} on {self.processor}", *named))


_NAMED = ("mujoco", "dm-control", "numpy", "scipy")
"""The packages on whose versions figures depend most."""


def environment() -> Environment:
    """Return that of this process; no package is imported."""
    packages = {}
    for name in sorted(MODULES):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            continue
    return Environment(platform.python_version(), platform.system(), platform.machine(), packages)
