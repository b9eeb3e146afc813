"""How long `tracerisk check` and `diff` take, beside an empty Python and ruff on the same files.

    python benchmarks/check_speed.py [--files N] [--repeat N] [--python ENV/bin/python]

One annotated controller, then N of them (1,000) below one lock; and `diff` of one of them, then
of all, changed since the last commit. Each figure is the median of a few runs of the whole command
in its own process, all made in this run: wall time, and processor time, which the load of the
machine changes less. A first run that does not count compiles our modules, as an installation
does, whatever the environment says of bytecode. `--python` is that of another environment, such as
one with a wheel: an editable installation, and `python -m`, take some ms of their own. What is
asked of them: one file at most 6 times the processor time of an empty Python, 1,000 at most 5 times
`ruff check --select ALL` of the same files, `diff` of 1,000 changed ones at most 5 s.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import quick

from tracerisk.adder.annotate import Changed, SourceBlocks, annotate_sources
from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.lock.lock import LOCK_NAME, Lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.freshness.run_inputs import RunInputs, settings_data

SAMPLE = Path(__file__).parents[1] / "sample_controllers" / "pick_and_place.py"
STEPS = ("init", "pick_position", "pick", "place_position", "place")


def make(folder: Path, names: Sequence[str]) -> None:
    """Write copies of the sample with a block in each of its five steps, and their lock."""
    source = SAMPLE.read_bytes()
    (folder / "pyproject.toml").write_text("[tool.tracerisk]\n", encoding="utf-8")
    blocks = {}
    for number, (step, following) in enumerate(zip(STEPS, (*STEPS[1:], "done"), strict=True), 1):
        parts = tuple(
            ComponentEntry(
                name,
                computed_probability(9.5e-08),
                computed_count(quantity),
                computed_redundancy(Redundancy(False)),
            )
            for name, quantity in (("electric_motor", 7), ("gripper", 1))
        )
        next_step = computed_next({following: 1})
        blocks[QualifiedName(step)] = RiskBlock(step, computed_count(number), next_step, parts)
    lock = Lock()
    for name in names:
        (folder / name).write_bytes(source)
        settings = settings_data(ProjectSettings(folder).of(name), folder)
        recorded = RunInputs(settings=settings, sources={name: code_digest(source, name)})
        outcome = annotate_sources(
            name,
            [SourceBlocks(name, source, blocks)],
            lock,
            fingerprint=recorded.fingerprint,
            trace={},
            inputs=recorded.data(),
            policy=MergePolicy(),
        )
        assert isinstance(outcome, Changed)
        (folder / name).write_bytes(outcome.sources[0].after)
        lock = outcome.lock
    (folder / LOCK_NAME).write_bytes(lock.dumps())


@dataclass(frozen=True)
class Times:
    """The median times of a command."""

    wall_s: float
    """[s]"""
    cpu_s: float
    """Of all its processes, [s]."""

    def __str__(self) -> str:
        return f"{self.wall_s:9.3f} {self.cpu_s:9.3f}"


def median(command: Sequence[str], folder: Path, repeat: int) -> Times:
    """Return the median times of a command after a first one; it must succeed."""
    times = []
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    for _ in range(repeat):
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        times.append((wall, cpu))
    walls, cpus = zip(*times, strict=True)
    return Times(statistics.median(walls), statistics.median(cpus))


def ratio(ours: Times, theirs: Times) -> str:
    """Return how many times as long ours takes, by wall and by processor time."""
    return f"{ours.wall_s / theirs.wall_s:.1f} (processor {ours.cpu_s / theirs.cpu_s:.1f}) times"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--python", type=Path, default=Path(sys.executable))
    options = quick.parsed(parser, files=lambda: 3, repeat=lambda: 1)
    with tempfile.TemporaryDirectory() as compiled:
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ["PYTHONPYCACHEPREFIX"] = compiled
        measure(options.files, options.repeat, options.python)


def measure(files: int, repeat: int, interpreter: Path) -> None:
    """Print the times for one controller, then for `files` of them."""
    python = [str(interpreter), "-c", "pass"]
    tracerisk = str(interpreter.with_name("tracerisk"))
    check = [tracerisk, "check", "-q"]
    ruff = shutil.which("ruff", path=str(Path(sys.executable).parent)) or shutil.which("ruff")
    print(f"{'files':>6} {'wall':>9} {'processor':>9}  [s, medians]")
    for count in (1, files):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            make(folder, [f"controller_{i:04d}.py" for i in range(count)])
            ours = median(check, folder, repeat)
            empty = median(python, folder, repeat)
            print(f"{count:6d} {empty}  python -c pass")
            print(f"{count:6d} {ours}  check: {ratio(ours, empty)} an empty Python")
            if ruff is not None:
                command = [ruff, "check", "--select", "ALL", "--no-cache", "--exit-zero", "-q", "."]
                theirs = median(command, folder, repeat)
                print(f"{count:6d} {theirs}  ruff; check takes {ratio(ours, theirs)} as long")
            done = subprocess.run(
                [*check[:-1], "--json"], cwd=folder, check=True, capture_output=True
            )
            assert len(json.loads(done.stdout)["fresh"]) == count
            commit(folder)
            for number in dict.fromkeys((1, count)):
                times = changed_since_commit(tracerisk, folder, number, repeat)
                print(f"{count:6d} {times}  diff, {number} changed")


def commit(folder: Path) -> None:
    """Commit all of a folder to a repository of its own."""
    identity = ("-c", "user.name=a", "-c", "user.email=a@example.org")
    for words in (("init", "-q"), ("add", "."), (*identity, "commit", "-q", "-m", "blocks")):
        subprocess.run(["git", *words], cwd=folder, check=True, capture_output=True)


def changed_since_commit(tracerisk: str, folder: Path, number: int, repeat: int) -> Times:
    """Return the times of `tracerisk diff` where one figure of some controllers changed."""
    for index in range(number):
        changed = folder / f"controller_{index:04d}.py"
        changed.write_bytes(changed.read_bytes().replace(b"9.5e-08", b"1.9e-07", 1))
    command = [tracerisk, "diff"]
    done = subprocess.run([*command, "--json"], cwd=folder, check=True, capture_output=True)
    assert len(json.loads(done.stdout)["controllers"]) == number
    return median(command, folder, repeat)


if __name__ == "__main__":
    main()
