"""What is made when a distribution is built: long description, compiled loops, man page."""

from __future__ import annotations

import gzip
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

PURE = "TRACERISK_PURE"
"""The variable that, set to anything, asks for a wheel of every machine, without compiled loops."""
REPOSITORY = "TRACERISK_REPOSITORY"
"""The variable that says where the repository is; without it there are no links to it."""

LIBRARY = "tracerisk/prm/compiled/loops.so"
"""The compiled loops, in a wheel and beside their sources."""
COMPILERS = ("cc", "gcc", "clang")
"""What is looked for where the variable CC says nothing."""
# The same digits on every machine: no operation is fused with another or reordered.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
OLDEST_PLATFORM = "manylinux_2_17"
"""The library needs no more of a C library than this one has."""
PAGES = "tracerisk/cli/set_up/pages.zip"
"""The pages of the documentation in a wheel, for `tracerisk docs`."""
MAN_PAGE = "share/man/man1/tracerisk.1"
"""Where `man` looks for it, in an environment's folder."""
COMMIT = "commit"
"""The file among the extra metadata of a wheel that names the commit it was built from."""
_WITHOUT = "trees are solved by Python alone, and large ones take very long"

_LINK = re.compile(r"\]\((?!https?:|#)([^)\s]+)\)")
_PICTURE = re.compile(r"(!\[[^\]]*\])\((?!https?:)([^)\s]+)\)")


class CustomMetadataHook(MetadataHookInterface):
    """Takes the README with absolute links, and names the pages of the repository."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set `readme` and `urls`."""
        root = Path(self.root)
        version = metadata["version"]
        is_release = re.fullmatch(r"[0-9.]+", version) is not None
        text = (root / "README.md").read_text(encoding="utf-8")
        repository = os.environ.get(REPOSITORY, "").rstrip("/")
        if repository:
            files = f"{repository}/blob/{f'v{version}' if is_release else 'HEAD'}"
            # A page about a file is no picture: those are taken as they are.
            text = _PICTURE.sub(rf"\1({files.replace('/blob/', '/raw/', 1)}/\2)", text)
            text = _LINK.sub(rf"]({files}/\1)", text)
            metadata["urls"] = {
                "Documentation": f"{files}/docs/tutorial.md",
                "Source": repository,
                "Changelog": f"{files}/CHANGELOG.md",
                "Issues": f"{repository}/issues",
            }
        metadata["readme"] = {"content-type": "text/markdown", "text": text}


class MadeFiles(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the loops into a wheel, or beside their sources for an editable installation.

    A wheel has the man page as well, and large data in less space.

    Where there is no C compiler, the wheel is one for every machine, and the loops run as Python.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the loops, say for which machine the wheel then is, write the man page."""
        root = Path(self.root)
        if version == "editable":
            compile_loops(root, root / LIBRARY)
            return
        self._folder = tempfile.TemporaryDirectory()
        page = Path(self._folder.name) / "tracerisk.1"
        page.write_text(man_page(root, self.metadata.version), encoding="utf-8")
        build_data["shared_data"][str(page)] = MAN_PAGE
        build_data["force_include"].update(packed_data(root, Path(self._folder.name)))
        if commit := built_commit(root):
            named = Path(self._folder.name) / COMMIT
            named.write_text(f"{commit}\n", encoding="utf-8")
            build_data["extra_metadata"][str(named)] = COMMIT
        library = Path(self._folder.name) / "loops.so"
        if compile_loops(root, library):
            build_data["force_include"][str(library)] = LIBRARY
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{platform_tag()}"

    def finalize(
        self,
        version: str,
        build_data: dict[str, Any],  # noqa: ARG002 - as hatchling calls it
        artifact_path: str,  # noqa: ARG002
    ) -> None:
        """Remove what was made, now that it is in the wheel."""
        if version != "editable":
            self._folder.cleanup()


def built_commit(root: Path) -> str:
    """Return the commit of the sources in a folder; empty where they are not just those of one."""
    if not (root / ".git").exists() or not shutil.which("git"):
        return ""
    head, changed = (
        subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=False)
        for words in (("rev-parse", "HEAD"), ("status", "--porcelain", "--untracked-files=no"))
    )
    return "" if head.returncode or changed.returncode or changed.stdout else head.stdout.strip()


def packed_data(root: Path, folder: Path) -> dict[str, str]:
    """Write data of the package into a folder in less space; return the place of each in a wheel.

    Texts of interfaces and pages of the documentation are compressed, schemas are written without
    white space. The source of the preloaded probe comes from its own distribution.
    """
    places = {str(root / "probe/native/calls.c"): "tracerisk/instrument/native/calls.c"}
    text = root / "tracerisk/ros/messages/interfaces.txt"
    packed = folder / f"{text.name}.gz"
    packed.write_bytes(gzip.compress(text.read_bytes(), mtime=0))
    places[str(packed)] = f"{text.relative_to(root)}.gz"
    pages = folder / Path(PAGES).name
    with zipfile.ZipFile(pages, "w", zipfile.ZIP_DEFLATED) as archive:
        for page in sorted((root / "docs").glob("*.md")):
            archive.writestr(zipfile.ZipInfo(page.name), page.read_bytes(), zipfile.ZIP_DEFLATED)
    places[str(pages)] = PAGES
    schemas = [
        *(root / "tracerisk").rglob("*.schema.json"),
        *(root / "tracerisk/prm/formats/schemas").glob("*.json"),
    ]
    for schema in sorted(schemas):
        short = folder / schema.name
        data = json.loads(schema.read_text(encoding="utf-8"))
        short.write_text(json.dumps(data, separators=(",", ":")) + "\n", encoding="utf-8")
        places[str(short)] = str(schema.relative_to(root))
    return places


def man_page(root: Path, version: str) -> str:
    """Return tracerisk(1), made of the parser in the sources below a folder."""
    from argparse_manpage.manpage import Manpage

    sys.path.insert(0, str(root))
    try:
        from tracerisk.cli.parser import whole_parser
    finally:
        sys.path.remove(str(root))
    parser = whole_parser()
    parser._positionals.title = "commands"
    (verbs,) = (each.choices for each in parser._actions if each.dest == "verb")
    for verb in verbs.values():
        verb.description = None  # the list of commands has it
    begin, _, codes = (parser.epilog or "").partition("\nexit codes:\n")
    parser.epilog = begin
    data = {
        "date": " ",  # the same page whenever it is made
        "description": "risk assessment of robot arms at every commit of their controllers",
        "manual_title": "Commands",
        "project_name": "tracerisk",
        "version": version,
    }
    os.environ["COLUMNS"] = "10000"  # lines are broken by `man`
    page = Manpage(parser, _data=data, format="single-commands-section")
    page.add_section("exit status", "=", f".nf\n{codes.rstrip()}\n.fi")
    return str(page)


def compile_loops(root: Path, library: Path) -> bool:
    """Compile the loops of the sources below a folder; return whether that could be done.

    On Windows they are not, for nobody has tried them there.
    """
    if os.environ.get(PURE) or sys.platform == "win32":
        return False
    sources = sorted(str(path) for path in (root / LIBRARY).parent.glob("*.c"))
    compiler = (
        shlex.split(os.environ.get("CC", ""))
        or [name for name in COMPILERS if shutil.which(name)][:1]
    )
    if not compiler:
        sys.stderr.write(f"no C compiler: {_WITHOUT}\n")
        return False
    # The old file may be in use: it is replaced, never written into.
    made = library.with_suffix(".new")
    command = [*compiler, *FLAGS, *sources, "-o", str(made)]
    try:
        done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    except OSError as error:
        sys.stderr.write(f"{compiler[0]} cannot be run ({error.strerror}): {_WITHOUT}\n")
        return False
    if done.returncode:
        words = next(iter(done.stderr.splitlines()), f"it ended with {done.returncode}")
        sys.stderr.write(f"{compiler[0]} failed ({words}): {_WITHOUT}\n")
        return False
    made.replace(library)
    return True


def platform_tag() -> str:
    """Return the platforms that a library compiled here is for, as a wheel's name says them."""
    from packaging.tags import platform_tags

    tags = list(platform_tags())
    return next((tag for tag in tags if tag.startswith(f"{OLDEST_PLATFORM}_")), tags[0])


if __name__ == "__main__":
    here = Path(__file__).parent
    sys.exit(0 if compile_loops(here, here / LIBRARY) else 1)
