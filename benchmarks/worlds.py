"""What runs in other worlds name, and what each costs beside the run itself.

Twelve programs that a race or a lucky start decides, written from public reports that each names,
are in `races/`; the samples of this repository are sound. With `--sound LIST` so are the
controllers of a JSON file of pairs: a folder, and the path of a controller in it.

    python benchmarks/worlds.py [PROGRAM ...] [--worlds NAMES] [--sound LIST]
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import quick

from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.common.worlds.world import ALL, NOMINAL, World, worlds_named
from tracerisk.common.worlds.world_run import dependence_line
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.evidence.cell_runs import nominal_of
from tracerisk.pipeline.run.controller_run import run_in_world
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.pipeline.worlds.world_runs import in_world, may_differ

RACES = Path(__file__).parent / "races"
SAMPLES = Path(__file__).parents[1] / "sample_controllers"
_SCENARIO = ".scenario.yaml"
_REPEATS = 3  # of the run itself, whose fastest counts


@dataclass(frozen=True, slots=True)
class Program:
    """A controller, and whether a world is to name it."""

    path: Path
    is_race: bool


@dataclass(frozen=True, slots=True)
class Found:
    """What the worlds named of a program, and how long each took beside the run itself."""

    named: tuple[str, ...]
    ratios: tuple[float, ...]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*", type=Path)
    parser.add_argument("--worlds", default=ALL)
    parser.add_argument("--sound", type=Path)
    options = quick.parsed(
        parser,
        programs=lambda: [RACES / "publish_at_once.py"],
        worlds=lambda: "discovery",
    )
    several_come()
    worlds = worlds_named(options.worlds)
    tried: list[tuple[Program, Found]] = []
    for program in _programs(options.programs, options.sound):
        try:
            result = _tried(program, worlds)
        except TraceRiskError as error:
            print(f"{program.path.name}: {error}", flush=True)
            continue
        tried.append((program, result))
        for line in result.named or ("nothing depends on a world",):
            print(f"{program.path.name}: {line}", flush=True)
    _report(tried)
    missed = [one for one, result in tried if bool(result.named) != one.is_race]
    return 1 if missed and not options.quick else 0


def _programs(given: Sequence[Path], listed: Path | None) -> Iterator[Program]:
    if given:
        yield from (Program(path, RACES in path.resolve().parents) for path in given)
        return
    yield from (Program(path, is_race=True) for path in sorted(RACES.glob("*.py")))
    yield from (Program(path, is_race=False) for path in sorted(SAMPLES.glob("*.py")))
    if listed is not None:
        for folder, path in json.loads(listed.read_text(encoding="utf-8")):
            yield Program(Path(folder, path), is_race=False)


def _tried(program: Program, worlds: Sequence[World]) -> Found:
    """Run a program, then in each world."""
    scenario = program.path.with_name(program.path.stem + _SCENARIO)
    given = (("scenario", str(scenario.resolve())),) if scenario.exists() else ()
    os.chdir(program.path.resolve().parent)
    nominal = nominal_of(str(program.path.resolve()), given)
    own_s = []
    for _ in range(_REPEATS):
        began = time.perf_counter()
        run_in_world(
            nominal.controller,
            nominal.run,
            nominal.settings,
            NOMINAL.name,
            RunOptions(quiet=True),
            duration_s=nominal.run.request.duration_s,
        )
        own_s.append(time.perf_counter() - began)
    named, ratios = [], []
    for world in worlds:
        if not may_differ(world, nominal):
            continue
        began = time.perf_counter()
        run = in_world(nominal, world)
        ratios.append((time.perf_counter() - began) / min(own_s))
        if run.depends:
            named.append(dependence_line(run))
    return Found(tuple(named), tuple(ratios))


def _report(tried: Sequence[tuple[Program, Found]]) -> None:
    for is_race, what in (
        (True, "that a race or a lucky start decides"),
        (False, "that are sound"),
    ):
        of_kind = [result for program, result in tried if program.is_race is is_race]
        if of_kind:
            named = sum(bool(result.named) for result in of_kind)
            print(f"{named} of {len(of_kind)} programs {what} are named by a world")
    ratios = sorted(ratio for _, result in tried for ratio in result.ratios)
    if ratios:
        print(
            f"{len(ratios)} runs in worlds, beside the run itself: median "
            f"{statistics.median(ratios):.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f} times"
        )


if __name__ == "__main__":
    sys.exit(main())
