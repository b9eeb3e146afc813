"""Pack the interface definitions of public message packages into the archive that is shipped.

    python benchmarks/interface_texts.py FOLDER [--check]

FOLDER holds a git repository for each one that docs/interfaces.md names, as OWNER+NAME; work trees
are not needed. Of each definition the types, names, constants and defaults are written, constants
first, without comments, and once for all distributions in which they are the same. With `--check`
nothing is written, and the exit code is 1 if the archive differs from what would be.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import quick

from tracerisk.ros.messages.interface_texts import canonical

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "docs" / "interfaces.md"
ARCHIVE = ROOT / "tracerisk" / "ros" / "messages" / "interfaces.txt"
DISTROS = ("noetic", "humble", "jazzy")

# Some packages sort them into folders below, which the names of the classes leave out.
_DEFINITION = re.compile(r"(msg|srv|action)/(?:.*/)?(\w+)\.\1")

Definitions = dict[str, str]
"""Texts by their places within a package: `msg/Pose.msg`."""


@dataclass(frozen=True, slots=True)
class Source:
    """A row of the table: where a package's definitions are."""

    package: str
    """The name under which it is imported."""
    repository: str
    """`owner/name`."""
    folder: str
    """Its folder in there, `.` for the top."""
    commits: Mapping[str, str]
    """The beginning of a commit's name, by distribution."""


def sources(page: str) -> Iterator[Source]:
    """Yield the rows of the table in a page."""
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| `") or len(cells) != 7:
            continue
        package, repository, folder, *versions, _ = cells
        commits = {
            distro: version.split()[-1]
            for distro, version in zip(DISTROS, versions, strict=True)
            if version
        }
        yield Source(package.strip("`"), repository, folder.strip("`"), commits)


def definitions(folder: Path, source: Source, distro: str) -> Definitions:
    """Return the definitions that a distribution has of a package, from its repository."""
    commit = source.commits[distro]
    repository = folder / source.repository.replace("/", "+")
    begin = "" if source.folder == "." else f"{source.folder}/"
    listed = _git(repository, "ls-tree", "-r", "--full-tree", commit, *([begin] if begin else []))
    texts: Definitions = {}
    for entry in listed.splitlines():
        stored, _, path = entry.partition("\t")
        match = _DEFINITION.fullmatch(path.removeprefix(begin))
        if match is not None:
            kind, stem = match.groups()
            text = _git(repository, "cat-file", "blob", stored.split()[2])
            texts.setdefault(
                f"{kind}/{stem}.{kind}", canonical(text, source.package, is_ros1=distro == "noetic")
            )
    return texts


def _git(repository: Path, *command: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(repository), *command], capture_output=True, check=False
    )
    if done.returncode:
        sys.exit(f"{repository}: {done.stderr.decode().strip()}")
    return done.stdout.decode("utf-8", "replace")


def archive_text(packages: Mapping[str, Mapping[str, Definitions]]) -> str:
    """Return the archive of packages, each with its definitions by distribution."""
    lines = []
    for package, of in sorted(packages.items()):
        own = [distro for distro in DISTROS if distro in of]
        lines.append(f"=== {package}: {' '.join(own)}\n")
        for place in sorted({place for texts in of.values() for place in texts}):
            by_text: dict[str, list[str]] = {}
            for distro in own:
                if place in of[distro]:
                    by_text.setdefault(of[distro][place], []).append(distro)
            for text, distros in by_text.items():
                where = "" if distros == own else f": {' '.join(distros)}"
                lines.append(f"== {place}{where}\n{text}")
    return "".join(lines)


def packed(folder: Path, page: str) -> str:
    """Return the archive of all packages that the table in a page has."""
    packages: dict[str, dict[str, Definitions]] = {}
    for source in sources(page):
        for distro in source.commits:
            of = packages.setdefault(source.package, {}).setdefault(distro, {})
            of |= definitions(folder, source, distro)
    return archive_text(packages)


def _quick_folder(folder: Path) -> str:
    """Make a repository of one package; return a page about it."""
    package = folder / "maker+arm" / "arm_msgs"
    for place, text in QUICK_PACKAGE.items():
        path = package / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    git = ["git", "-C", str(package.parent), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "Add messages"]):
        subprocess.run([*git, *command], check=True)
    return "| `arm_msgs` | maker/arm | `arm_msgs` | 1.0.0 HEAD |  | 1.0.0 HEAD | BSD |\n"


QUICK_PACKAGE = {
    "msg/Joint.msg": "# a joint\nHeader header\nfloat64 angle # [rad]\nuint8 FREE = 1\n",
    "srv/Stop.srv": "---\nbool success\narm_msgs/Joint[] joints\n",
}


def main() -> None:
    """Write the archive, or compare it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path, nargs="?")
    parser.add_argument("--check", action="store_true")
    options = quick.parsed(parser)
    if options.quick:
        folder = quick.folder({})
        print(packed(folder, _quick_folder(folder)), end="")
        return
    if options.folder is None:
        parser.error("give the folder of the repositories")
    text = packed(options.folder, TABLE.read_text(encoding="utf-8"))
    if options.check:
        is_same = ARCHIVE.read_text(encoding="utf-8") == text
        print(f"{ARCHIVE.name} {'is' if is_same else 'differs from'} what the repositories have")
        sys.exit(not is_same)
    ARCHIVE.write_text(text, encoding="utf-8")
    print(f"{ARCHIVE.name}: {text.count('=== ')} packages, {len(text) / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
