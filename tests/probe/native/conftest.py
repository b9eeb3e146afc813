"""Compiled nodes, and the probe that is loaded before them."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tracerisk.instrument.native.calls import CallLog, read_calls
from tracerisk.instrument.native.library import build_probe

HERE = Path(__file__).parent


class Nodes:
    """Programs compiled against the few classes of `ros.h`, run with the probe."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.library = build_probe(folder)
        self._ros = folder / "libroscpp.so"
        self._compile("g++", ["-O1", "-g", "-fPIC", "-shared", str(HERE / "ros.cpp")], self._ros)

    def _compile(self, compiler: str, arguments: list[str], to: Path) -> Path:
        if shutil.which(compiler) is None:
            pytest.skip(f"no {compiler}")
        subprocess.run([compiler, *arguments, "-o", str(to)], check=True)
        return to

    def compile(self, *flags: str, source=HERE / "node.cpp", compiler="g++", name="node") -> Path:
        sources = [source] if isinstance(source, Path) else source
        wanted = [*map(str, sources), "-I", str(HERE), str(self._ros), f"-Wl,-rpath,{self.folder}"]
        return self._compile(compiler, [*flags, *wanted, "-pthread"], self.folder / name)

    def run(self, program: Path, *arguments: str, to="calls.jsonl", fresh=True, before=()):
        """Run a node with the probe; return how it ended."""
        file = self.folder / to
        if fresh:
            file.unlink(missing_ok=True)
        changed = {"LD_PRELOAD": str(self.library), "TRACERISK_CALLS": str(file)}
        return subprocess.run(
            [*before, str(program), *arguments],
            env={**os.environ, **changed},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    def log(self, names_at=None) -> CallLog:
        return read_calls(self.folder / "calls.jsonl", names_at)


@pytest.fixture(scope="session")
def nodes(tmp_path_factory):
    if shutil.which("g++") is None:
        pytest.skip("no g++")
    return Nodes(tmp_path_factory.mktemp("native"))


@pytest.fixture(scope="session")
def node(nodes):
    return nodes.compile("-O2", "-g", "-fno-optimize-sibling-calls")
