"""Make the table of modules and the distributions that provide them.

    python benchmarks/module_table.py NAME... > tracerisk/ros/imports/data/modules.csv

Each distribution is installed without its dependencies into a folder that is thrown away, and its
own metadata says which modules it brings: a folder or a module at the top of what it installs.
Names that Python itself has, and those of tests, documentation and private parts, are left out.
What cannot be installed is named on the standard error and left out. Without names the
distributions are those of the table as it stands.
"""

from __future__ import annotations

import argparse
import csv
import importlib.metadata
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import quick

TABLE = Path(__file__).parents[1] / "tracerisk" / "ros" / "imports" / "data" / "modules.csv"
_NO_MODULES = frozenset({"bin", "docs", "doc", "examples", "share", "test", "tests", "include"})


def main() -> None:
    """Print the table of the distributions, sorted by module."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="distributions, as pip takes them")
    names = quick.parsed(parser, names=lambda: [_wheel()]).names
    rows = sorted({row for name in names or _present() for row in _rows(name)})
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(("module", "distribution"))
    writer.writerows(rows)


def _present() -> list[str]:
    with TABLE.open(encoding="utf-8", newline="") as stream:
        return sorted({row["distribution"] for row in csv.DictReader(stream)})


def _wheel() -> str:
    """Return a distribution of one module, which pip installs without a network."""
    path = quick.folder({}) / "turning-1.0-py3-none-any.whl"
    info = "turning-1.0.dist-info"
    files = {
        "turning.py": "ANGLE = 0.1\n",
        f"{info}/METADATA": "Metadata-Version: 2.1\nName: turning\nVersion: 1.0\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info}/RECORD": f"turning.py,,\n{info}/METADATA,,\n{info}/WHEEL,,\n{info}/RECORD,,\n",
    }
    with zipfile.ZipFile(path, "w") as wheel:
        for name, text in files.items():
            wheel.writestr(name, text)
    return str(path)


def _rows(name: str) -> Iterator[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as folder:
        command = (sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-compile")
        done = subprocess.run(
            [*command, "--target", folder, name], stdout=sys.stderr, check=False, text=True
        )
        if done.returncode:
            sys.stderr.write(f"{name}: left out, pip cannot install it\n")
            return
        for distribution in importlib.metadata.distributions(path=[folder]):
            for module in sorted(modules_of(distribution)):
                yield module, name


def modules_of(distribution: importlib.metadata.Distribution) -> set[str]:
    """Return the top names that a distribution makes importable, by its list of files."""
    tops: set[str] = set()
    for file in distribution.files or ():
        # Some bring a whole prefix, which a file of theirs puts on the path.
        at = file.parts.index("site-packages") + 1 if "site-packages" in file.parts else 0
        parts = file.parts[at:]
        first = parts[0]
        if len(parts) == 1:
            is_module = file.suffix in (".py", ".so", ".pyd")
            top = first.partition(".")[0] if is_module else ""
        else:
            top = first if file.suffix in (".py", ".so", ".pyd") else ""
        is_private = top.startswith("_") or not top.isidentifier() or top in _NO_MODULES
        if not is_private and top not in sys.stdlib_module_names:
            tops.add(top)
    return tops


if __name__ == "__main__":
    main()
