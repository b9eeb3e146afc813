"""Look at a built sdist and wheel: what they hold, and what their metadata says.

Usage: package_contents.py FOLDER REPOSITORY
"""

from __future__ import annotations

import re
import shutil
import sys
import tarfile
import zipfile
from collections.abc import Iterable
from email import message_from_string
from pathlib import Path

TOP_OF_SDIST = {
    *("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "PKG-INFO", "README.md", "hatch_build.py"),
    *("pyproject.toml", "mkdocs.yml", ".gitignore", ".pre-commit-hooks.yaml", "action.yml"),
    *("action", "benchmarks", "docs", "editors", "probe", "sample_controllers", "tests"),
    "tracerisk",
}
MUST_BE = (
    "tracerisk/py.typed",
    "tracerisk/cli/set_up/pages.zip",
    "tracerisk/common/hardware/hardware.schema.json",
    "tracerisk/instrument/native/calls.c",
    "tracerisk/report/html/assets/page.css",
    "tracerisk/ros/live/messages/moveit/move_group_interface/move_group_interface.h",
    "tracerisk/ros/messages/interfaces.txt.gz",
    "tracerisk/twin/robots/shipped/panda.yaml",
)
PLACED = {"share/man/man1/tracerisk.1"}
LOOPS = "tracerisk/prm/compiled/"
LIBRARY = f"{LOOPS}loops.so"
PLACEHOLDER = re.compile(r"OWNER|REPOSITORY|TODO|FIXME|XXX")


def main(folder: Path, repository: str) -> None:
    """Exit with what is wrong, or print what was built."""
    wheels = sorted(folder.glob("tracerisk-*.whl"))
    compiled = [wheel for wheel in wheels if not is_pure(wheel)]
    expect(len(wheels) - len(compiled) == 1, f"wheels: {[wheel.name for wheel in wheels]}")
    expect(len(compiled) == (shutil.which("cc") is not None), "the wheel of this machine")
    (sdist,) = folder.glob("tracerisk-*.tar.gz")
    for wheel in wheels:
        check_wheel(wheel, repository)
    with tarfile.open(sdist) as packed_source:
        inside = {name.split("/")[1] for name in packed_source.getnames() if "/" in name}
    expect(inside == TOP_OF_SDIST, f"in the sdist: {sorted(inside ^ TOP_OF_SDIST)}")
    check_no_leftovers(inside)
    check_probe(folder)
    print(f"{sdist.name}: {sdist.stat().st_size / 1e6:.1f} MB")


def is_pure(wheel: Path) -> bool:
    """Return whether a wheel is for every machine."""
    return wheel.stem.endswith("-any")


def check_no_leftovers(names: Iterable[str]) -> None:
    """Exit with a file that Python has left where nobody wants it."""
    for left in names:
        expect("__pycache__" not in left and not left.endswith(".pyc"), f"left over: {left}")


def check_wheel(wheel: Path, repository: str) -> None:
    """Exit with what is wrong with a wheel, or print its size."""
    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        (metadata,) = [name for name in names if name.endswith(".dist-info/METADATA")]
        text = packed.read(metadata).decode()
    tops = {name.partition("/")[0] for name in names}
    folder_of_metadata = metadata.partition("/")[0]
    data = folder_of_metadata.replace(".dist-info", ".data")
    expect(tops == {"tracerisk", folder_of_metadata, data}, f"in the wheel: {sorted(tops)}")
    placed = {name.removeprefix(f"{data}/data/") for name in names if name.startswith(f"{data}/")}
    expect(placed == PLACED, f"placed in the environment: {sorted(placed)}")
    missing = [name for name in MUST_BE if name not in names]
    expect(not missing, f"not in the wheel: {missing}")
    expect_library(wheel, names)
    check_no_leftovers(names)

    told = message_from_string(text)
    description = told.get_payload()
    assert isinstance(description, str)
    urls = told.get_all("Project-URL") or []
    expect(len(urls) >= 3 and all(repository in url for url in urls), f"URLs: {urls}")
    expect(told["Description-Content-Type"] == "text/markdown", "the description is no Markdown")
    expect(told["License-Expression"] == "Apache-2.0", f"licence: {told['License-Expression']}")
    links = re.findall(r"\]\(([^)\s]+)\)", description)
    relative = [link for link in links if not link.startswith("https://")]
    expect(bool(links) and not relative, f"links that are not absolute: {relative}")
    header = text[: text.index("\n\n")]
    expect(PLACEHOLDER.search(header) is None, "a placeholder in the metadata")
    extras = set(told.get_all("Provides-Extra") or [])
    expect({"sim", "large", "dev", "test", "docs"} <= extras, f"extras: {sorted(extras)}")
    print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e6:.1f} MB")


def expect_library(wheel: Path, names: list[str]) -> None:
    """Exit unless a wheel for one machine has the compiled loops, and no other has them."""
    compiled = not is_pure(wheel)
    expect((LIBRARY in names) == compiled, f"the compiled loops in {wheel.name}: {not compiled}")
    loops = [name for name in names if name.startswith(LOOPS) and name.endswith((".c", ".h"))]
    expect(not loops, f"sources of the compiled loops in the wheel: {', '.join(loops)}")
    if compiled:
        with zipfile.ZipFile(wheel) as packed:
            needed = re.findall(rb"GLIBC_2\.(\d+)", packed.read(LIBRARY))
        newest = max(map(int, needed), default=0)
        expect(newest <= 17, f"the compiled loops need glibc 2.{newest}")


def check_probe(folder: Path) -> None:
    """Exit unless the probe is one package for Python 3.8 that depends on nothing."""
    (wheel,) = folder.glob("tracerisk_probe-*.whl")
    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        (metadata,) = [name for name in names if name.endswith(".dist-info/METADATA")]
        told = message_from_string(packed.read(metadata).decode())
    tops = {name.partition("/")[0] for name in names}
    expect(tops == {"tracerisk_probe", metadata.partition("/")[0]}, f"in the probe: {sorted(tops)}")
    expect("tracerisk_probe/py.typed" in names, "the probe is not typed")
    expect(told["Requires-Python"] == ">=3.8", f"the probe needs {told['Requires-Python']}")
    expect(not told.get_all("Requires-Dist"), "the probe depends on something")
    print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e3:.0f} kB")


def expect(is_so: bool, otherwise: str) -> None:
    """Exit with a message unless it is so."""
    if not is_so:
        sys.exit(f"package: {otherwise}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
