"""The packages that tracerisk depends on, and a clear error where one cannot be imported."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterable, Mapping
from importlib import import_module, metadata

from tracerisk.errors import DependencyError

MODULES: Mapping[str, str] = {
    "daqp": "daqp",
    "dm-control": "dm_control.mujoco",
    "etils": "etils.epath",
    "jinja2": "jinja2",
    "lark": "lark",
    "libcst": "libcst",
    "mink": "mink",
    "mujoco": "mujoco",
    "numba": "numba",
    "numpy": "numpy",
    "pillow": "PIL",
    "pygments": "pygments",
    "pyyaml": "yaml",
    "rich": "rich",
    "rosbags": "rosbags",
    "ruamel.yaml": "ruamel.yaml",
    "scipy": "scipy",
    "shtab": "shtab",
    "six": "six",
    "tomli": "tomli",
    "xacrodoc": "xacrodoc",
}
"""The module of each distribution that `pyproject.toml` lists."""

SIMULATION = ("daqp", "libcst", "mink", "mujoco", "numpy", "rosbags", "ruamel.yaml", "scipy")
"""The distributions without which no controller runs."""


def needed() -> tuple[str, ...]:
    """Return the distributions that this version of Python needs.

    dm-control is used where it can be imported, and needed nowhere.
    """
    absent = {"dm-control"}
    if sys.version_info >= (3, 11):
        absent |= {"etils", "tomli"}
    return tuple(name for name in MODULES if name not in absent)


def version_of(distribution: str) -> str:
    """Return the version of a distribution that can be imported.

    Raises DependencyError with the module, the interpreter and what to do.
    """
    try:
        import_module(MODULES[distribution])
        return metadata.version(distribution)
    except ImportError as cause:
        raise cannot_import(distribution_of(cause) or distribution, cause) from cause


def check(distributions: Iterable[str]) -> None:
    """Import each distribution; raise DependencyError at the first that cannot be imported."""
    for distribution in distributions:
        version_of(distribution)


def cannot_import(distribution: str, cause: ImportError) -> DependencyError:
    """Return the error for a distribution that cannot be imported."""
    return DependencyError(
        f"module '{MODULES[distribution]}' cannot be imported by Python "
        f"{platform.python_version()} ({sys.executable}): {cause}; install it with "
        f"`{sys.executable} -m pip install --force-reinstall --only-binary=:all: {distribution}`, "
        "or use an interpreter for which it has a wheel (Python 3.10 to 3.14); "
        "`tracerisk doctor` lists every package"
    )


def distribution_of(error: ImportError) -> str | None:
    """Return which distribution an import failed for, `None` where it is none of ours."""
    top = (error.name or "").partition(".")[0]
    return next((name for name, module in MODULES.items() if module.partition(".")[0] == top), None)
