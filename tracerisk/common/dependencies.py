"""The packages that tracerisk depends on, and a clear error where one cannot be imported."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.util import find_spec

from tracerisk.errors import DependencyError, OtherSystemError

MODULES: Mapping[str, str] = {
    "av": "av",
    "cyclonedds": "cyclonedds",
    "daqp": "daqp",
    "dm-control": "dm_control.mujoco",
    "etils": "etils.epath",
    "fissix": "fissix",
    "greenlet": "greenlet",
    "jinja2": "jinja2",
    "lark": "lark",
    "libcst": "libcst",
    "lsprotocol": "lsprotocol.types",
    "mcap": "mcap",
    "mink": "mink",
    "mujoco": "mujoco",
    "numpy": "numpy",
    "pillow": "PIL",
    "pygls": "pygls.lsp.server",
    "pygments": "pygments",
    "pymoveit2": "pymoveit2",
    "pyyaml": "yaml",
    "rich": "rich",
    "rosbags": "rosbags",
    "ruamel.yaml": "ruamel.yaml",
    "scipy": "scipy",
    "shtab": "shtab",
    "six": "six",
    "tomli": "tomli",
    "tree-sitter": "tree_sitter",
    "tree-sitter-c": "tree_sitter_c",
    "tree-sitter-cpp": "tree_sitter_cpp",
    "xacrodoc": "xacrodoc",
}
"""The module of each distribution that `pyproject.toml` lists."""

EXTRAS: Mapping[str, tuple[str, ...]] = {
    "sim": (
        *("daqp", "dm-control", "etils", "fissix", "greenlet", "lark", "libcst", "mcap", "mink"),
        *("mujoco", "numpy", "pillow", "pymoveit2", "rosbags", "scipy", "six", "xacrodoc"),
    ),
    "large": ("numpy", "scipy"),
    "sysml": ("lark",),
    "python2": ("fissix",),
    "cpp": ("tree-sitter", "tree-sitter-c", "tree-sitter-cpp"),
    "lsp": ("lsprotocol", "pygls"),
    "film": ("av",),
    "dds": ("cyclonedds",),
}
"""The distributions of the extras that verbs of `tracerisk` use; all others are always there."""

ONLY_IN_RUNS = ("pymoveit2",)
"""The distributions that import ROS, and so can be imported in a run alone."""

SIMULATION = ("daqp", "libcst", "mink", "mujoco", "numpy", "rosbags", "ruamel.yaml", "scipy")
"""The distributions without which no controller runs."""

_SIGN = {
    "sim": "mujoco",
    "large": "scipy",
    "sysml": "lark",
    "python2": "fissix",
    "cpp": "tree-sitter-cpp",
    "lsp": "pygls",
    "film": "av",
    "dds": "cyclonedds",
}
"""What shows that an extra is installed; `sim` brings all of `large`, `python2` and `sysml`."""
_WHAT = {
    "sim": "the simulator",
    "large": "NumPy and SciPy",
    "sysml": "lark",
    "python2": "fissix",
    "cpp": "tree-sitter",
    "lsp": "pygls",
    "film": "av",
    "dds": "cyclonedds, which supports Python 3.10 to 3.13, but not Linux on ARM",
}


def is_installed(distribution: str) -> bool:
    """Whether the module of a distribution is there; it may fail to be imported all the same."""
    top = MODULES[distribution].partition(".")[0]
    if top in sys.modules:
        return True  # it may have been put there by hand, without a spec
    spec = find_spec(top)
    if spec is None or spec.has_location:
        return spec is not None
    # A namespace package, as rosbags is, or any folder of that name: only an installer knows which.
    from importlib.metadata import PackageNotFoundError, version  # slow to import

    try:
        version(distribution)
    except PackageNotFoundError:
        return False
    return True


def missing_extras() -> tuple[str, ...]:
    """Return the extras that are not installed."""
    return tuple(extra for extra, sign in _SIGN.items() if not is_installed(sign))


def install_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'tracerisk[{extra}]'"


def missing_extra(extra: str, purpose: str) -> DependencyError:
    """Return the error for a purpose that needs an extra which is not installed."""
    needs, it = ("need", "them") if extra == "large" else ("needs", "it")
    command = install_command(extra)
    return DependencyError(f"{purpose} {needs} {_WHAT[extra]}; install {it}: {command}")


def require_simulator(purpose: str) -> None:
    """Raise DependencyError unless the extra `sim` is installed; `purpose` says what needs it."""
    if not is_installed("mujoco"):
        raise missing_extra("sim", purpose)


def require_linux(purpose: str) -> None:
    """Raise OtherSystemError where the system is not Linux; `purpose` says what needs it."""
    if sys.platform != "linux":
        name = {"win32": "Windows", "darwin": "macOS"}.get(sys.platform, sys.platform)
        wsl = "`wsl` or " if name == "Windows" else ""
        raise OtherSystemError(
            f"{purpose} needs Linux, and this is {name}; open a shell of Linux with {wsl}"
            "`docker run -it --rm -v .:/work -w /work python:3.13 bash`, and run there "
            f"`{install_command('sim')}` and this command again"
        )


def require_runs(purpose: str) -> None:
    """Raise an error unless controllers can run here; `purpose` says what needs that.

    Raises OtherSystemError where the system is not Linux, DependencyError without the simulator.
    """
    require_linux(purpose)
    require_simulator(purpose)


def require_cpp() -> None:
    """Raise DependencyError unless the extra `cpp` is installed."""
    if not all(map(is_installed, EXTRAS["cpp"])):
        raise missing_extra("cpp", "reading the functions of C and C++")


def require_lsp() -> None:
    """Raise DependencyError unless the extra `lsp` is installed."""
    if not all(map(is_installed, EXTRAS["lsp"])):
        raise missing_extra("lsp", "the language server")


def require_film() -> None:
    """Raise DependencyError unless the extra `film` is installed."""
    if not all(map(is_installed, EXTRAS["film"])):
        raise missing_extra("film", "a film as MP4")


def require_dds() -> None:
    """Raise DependencyError unless the extra `dds` is installed."""
    if not all(map(is_installed, EXTRAS["dds"])):
        raise missing_extra("dds", "listening to a ROS 2 robot")


def require_large(*distributions: str) -> None:
    """Raise DependencyError unless these distributions of the extra `large` are installed."""
    if not all(map(is_installed, distributions)):
        raise missing_extra("large", "samples, quantiles and large models")


def needed() -> tuple[str, ...]:
    """Return the distributions that this version of Python needs, with the extras that are here.

    dm-control and greenlet are used where they can be imported, and needed nowhere.
    """
    absent = {"dm-control", "greenlet"}
    if sys.version_info >= (3, 11):
        absent |= {"etils", "tomli"}
    missing = missing_extras()
    for name in MODULES:
        extras = [extra for extra, names in EXTRAS.items() if name in names]
        if extras and all(extra in missing for extra in extras):
            absent.add(name)
    return tuple(name for name in MODULES if name not in absent)


def version_of(distribution: str) -> str:
    """Return the version of a distribution that can be imported.

    Raises DependencyError with the module, the interpreter and what to do.
    """
    from importlib import metadata

    try:
        if distribution not in ONLY_IN_RUNS:
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
    import platform

    return DependencyError(
        f"module '{MODULES[distribution]}' cannot be imported by Python "
        f"{platform.python_version()} ({sys.executable}): {cause}; install it with "
        f"`{sys.executable} -m pip install --force-reinstall --only-binary=:all: {distribution}`, "
        "or use an interpreter that it has a wheel for (Python 3.10 to 3.14); "
        "`tracerisk doctor` lists every package"
    )


def error_of(error: ImportError, purpose: str) -> DependencyError | None:
    """Return the error for an import that failed, `None` where it is none of ours.

    `purpose` is what needed the module, for a module of the simulator that is not installed.
    """
    distribution = distribution_of(error)
    if distribution is None:
        return None
    if distribution in EXTRAS["sysml"]:
        return missing_extra("sysml", "a hardware description in SysML v2")
    if distribution in EXTRAS["sim"] and "sim" in missing_extras():
        return missing_extra("sim", purpose)
    if distribution in EXTRAS["large"] and "large" in missing_extras():
        return missing_extra("large", purpose)
    return cannot_import(distribution, error)


def distribution_of(error: ImportError) -> str | None:
    """Return which distribution an import failed for, `None` where it is none of ours."""
    top = (error.name or "").partition(".")[0]
    return next((name for name, module in MODULES.items() if module.partition(".")[0] == top), None)
