"""With what a dossier was made: the versions of Python and of the packages, and the processor."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution, version
from typing import Any

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

    installed_from: str = ""
    """What tracerisk was installed from: the commit of git, or the digest of its archive; "" where
    neither pip nor the build noted it."""

    @property
    def constraints(self) -> str:
        """The versions as a file of constraints for pip."""
        return "".join(f"{name}=={number}\n" for name, number in self.packages.items())

    @property
    def words(self) -> str:
        """What the simulation depends on, in short."""
        named = [f"{name} {self.packages[name]}" for name in _NAMED if name in self.packages]
        return ", ".join((f"Python {self.python}", f"{self.system} on {self.processor}", *named))

    def wanted(self, version: str) -> tuple[str, str]:
        """Return what pip is to install for a version, and a sentence on it; empty for none."""
        if ".dev" not in version:
            return f"tracerisk[sim]=={version}", ""
        kind, _, commit = self.installed_from.partition(" ")
        none = f"No package index has version {version}, a development version: install it from "
        if kind == "commit":
            where = "its commit, with `REPOSITORY` for the address of tracerisk's repository. "
            return f"tracerisk[sim] @ git+REPOSITORY@{commit}", none + where
        if self.installed_from:
            where = f"the {self.installed_from}, with `WHEEL` for the path of that file. "
            return "WHEEL[sim]", none + where
        where = (
            "its source, with `SOURCE` for the folder. Of which commit it is, the installation "
            "does not say: ask who made this dossier. "
        )
        return "SOURCE[sim]", none + where


_NAMED = ("mujoco", "dm-control", "numpy", "scipy")
"""The packages on whose versions figures depend most."""
_COMMIT = "extra_metadata/commit"
"""Where `hatch_build.py` puts the commit that a wheel was built from."""


def environment() -> Environment:
    """Return that of this process; no package is imported."""
    packages = {}
    for name in sorted(MODULES):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            continue
    return Environment(
        *(platform.python_version(), platform.system(), platform.machine(), packages),
        installed_from=_installed_from(),
    )


def _installed_from() -> str:
    """Return what the build noted of the origin of tracerisk, else pip: PEP 610."""
    try:
        installed = distribution("tracerisk")
    except PackageNotFoundError:
        return ""
    commit = (installed.read_text(_COMMIT) or "").strip()
    noted = {"vcs_info": {"commit_id": commit}} if commit else None
    return origin_words(noted or json.loads(installed.read_text("direct_url.json") or "{}"))


def origin_words(noted: Mapping[str, Any]) -> str:
    """Return the commit or the digest in a `direct_url.json`; no place of this machine."""
    commit = noted.get("vcs_info", {}).get("commit_id")
    if commit:
        return f"commit {commit}"
    hashes = noted.get("archive_info", {}).get("hashes", {})
    return ", ".join(f"archive with {name} {digest}" for name, digest in sorted(hashes.items()))
