"""Break controllers that work, one at a time, and compare the verdict of each run with its physics.

    python benchmarks/broken_controllers.py [--most 1] [--jobs 2] [--only TEXT]

Samples and the programs of `broken_cases` are broken in ways that are found automatically
(`broken_kinds`), and refactored (`broken_refactorings`). Whether the mission is still carried out
is judged from the recorded physics alone (`broken_mission`), against the unbroken run.

A breakage that keeps the mission from being carried out is noticed by one of these rules alone:

1. tracerisk refuses the run, or its verdict is `stuck`;
2. its verdict is `faulted` or `partial`, and one of its reasons that are not accepted has a code,
   function and object that no reason of the unbroken run has.

Whatever else a run shows does not count: a finding or a reason beside `complete`, a reason that
the unbroken run has as well, a figure that moved, an exit code, an internal error of tracerisk.

A false alarm is a mission that is carried out with a verdict worse than that of the unbroken run.
Prints a table of each; exits 1 where less than 95 % are noticed, or with a false alarm.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import quick
from broken_kinds import KINDS, MOVED, Breakage, Commanded, Unbroken, breakages, spread
from broken_mission import Mission, missing, read_mission
from broken_refactorings import REFACTORINGS, refactorings

ROOT = Path(__file__).parents[1]
SAMPLES, CASES = ROOT / "sample_controllers", Path(__file__).parent / "broken_cases"
SCENES = ROOT / "tracerisk" / "twin" / "physics" / "scenes"
RANKS = ("complete", "partial", "faulted", "stuck")
LEAST_NOTICED = 0.95


@dataclass(frozen=True)
class Case:
    """A controller: the folder it is copied from, its script, and the options of its run."""

    name: str
    folder: Path
    script: str
    options: tuple[str, ...] = ()
    more: tuple[Path, ...] = ()
    """Files that are copied beside it."""


@dataclass(frozen=True)
class Outcome:
    """A run: its verdict, its reasons, and what happened."""

    verdict: str
    """Of `RANKS`; else `refused` or `internal error`."""
    reasons: frozenset[tuple[str, str, str]]
    """Code, function and object of each reason that is not accepted."""
    words: str
    mission: Mission | None


@dataclass(frozen=True)
class Row:
    """A breakage or refactoring, judged."""

    case: str
    breakage: Breakage
    lacks: str
    """What of the mission is not carried out; empty where all is."""
    verdict: str
    words: str
    is_noticed: bool
    is_worse: bool

    @property
    def is_miss(self) -> bool:
        return bool(self.lacks) and not self.is_noticed

    @property
    def is_false_alarm(self) -> bool:
        return not self.lacks and self.is_worse


def _own(name: str, robot: str) -> Case:
    options: tuple[str, ...] = ("--robot", robot)
    if (CASES / name / "scenario.yaml").exists():
        options += ("--scenario", "scenario.yaml")
    more = (CASES / robot,) if robot.endswith(".urdf") else ()
    return Case(name, CASES / name, f"{name}.py", options, more)


def _sample(name: str, *options: str, more: tuple[Path, ...] = ()) -> Case:
    return Case(name, SAMPLES, f"{name}.py", options, more)


def cases() -> tuple[Case, ...]:
    """Return the controllers to break."""
    racks = SCENES / "tube_racks.yaml"
    sorting = "part_sorting/src/part_sorting/scripts/sort_parts.py"
    own = {
        **dict.fromkeys(("block_stacking", "lid_closing"), "panda"),
        "peg_pulling": "panda",
        "polishing": "ur5e",
        "sorting": "small_arm.urdf",
    }
    return (
        _sample("careful_pick", "--scene", "scene.yaml", more=(racks,)),
        _sample("glue_bead"),
        _sample("machine_tending"),
        _sample("pick_and_place", "--scene", "scene.yaml", more=(racks,)),
        _sample("shelf_stocking"),
        _sample("surface_scan"),
        Case("part_sorting", SAMPLES, sorting),
        *(
            _own(path.name, own.get(path.name, "arm.urdf"))
            for path in sorted(CASES.iterdir())
            if path.is_dir() and (path / f"{path.name}.py").exists()
        ),
    )


def lay_out(case: Case, folder: Path) -> None:
    """Copy a controller into a folder, as the root of a project."""
    folder.mkdir(parents=True)
    (folder / "pyproject.toml").write_bytes(b"")
    top = case.script.partition("/")[0]
    if "/" in case.script:
        shutil.copytree(case.folder / top, folder / top)
    elif case.folder == SAMPLES:
        shutil.copy(case.folder / top, folder / top)
    else:
        shutil.copytree(case.folder, folder, dirs_exist_ok=True)
    for path in case.more:
        shutil.copy(path, folder / ("scene.yaml" if path.suffix == ".yaml" else path.name))


def files_of(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".py", ".yaml", ".urdf") and "keep" not in path.parts
    }


def run(case: Case, folder: Path) -> Outcome:
    """Run a controller that lies in a folder, and return how it went."""
    keep = folder / "keep"
    limits = ("--cpu-limit", "60", "--wall-limit", "150", "--stall-limit", "8")
    ended = subprocess.run(
        [
            *(sys.executable, "-m", "tracerisk", "trace", case.script),
            *(*case.options, *limits, "--json", "--keep", str(keep)),
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    try:
        loads: dict[str, Any] = json.loads(ended.stdout)
    except ValueError:
        return Outcome("internal error", frozenset(), ended.stderr[-300:], None)
    trace = loads.get("trace") or {}
    given = loads.get("verdict")
    verdict = trace.get("verdict") or (given if isinstance(given, dict) else {})
    reasons = [item for item in verdict.get("reasons") or () if not item["accepted"]]
    kind = verdict.get("kind") or (given if isinstance(given, str) else "") or "refused"
    words = loads.get("verdict_line") or str((loads.get("error") or {}).get("message"))
    keys = frozenset((reason["code"], reason["function"], reason["object"]) for reason in reasons)
    return Outcome(kind, keys, " ".join(words.split())[:170], read_mission(keep))


def unbroken_of(folder: Path) -> Unbroken:
    """Return a controller with what the events of its run show."""
    robot = json.loads((folder / "keep" / "robot.json").read_text(encoding="utf-8"))
    grippers = {item["name"] for item in robot["grippers"]}
    names = {item["name"] for item in robot["joints"]} | set(robot["groups"])
    files: dict[int, str] = {}
    commands = []
    for line in (folder / "keep" / "events.jsonl").read_text(encoding="utf-8").splitlines():
        event = json.loads(line)
        if event["event"] == "function":
            files[event["id"]] = event["file"]
        elif event["event"] == "command":
            sites = tuple((files[item[0]], item[2], item[3]) for item in event["stack"])
            commands.append(Commanded(sites, set(event["elements"]) <= grippers))
    return Unbroken(files_of(folder), frozenset(names), tuple(commands))


def _run_broken(case: Case, breakage: Breakage, nominal: Outcome, folder: Path) -> Row:
    lay_out(case, folder)
    for name, text in breakage.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    outcome = run(case, folder)
    assert nominal.mission is not None
    lacks = missing(nominal.mission, outcome.mission)
    shutil.rmtree(folder)
    is_worse = _rank(outcome.verdict) > _rank(nominal.verdict)
    noticed = is_noticed(nominal, outcome)
    return Row(case.name, breakage, lacks, outcome.verdict, outcome.words, noticed, is_worse)


def is_noticed(unbroken: Outcome, broken: Outcome) -> bool:
    """Return whether a run notices that its controller is broken, by the rules above."""
    if broken.verdict in ("refused", "stuck"):
        return True
    return broken.verdict in ("faulted", "partial") and bool(broken.reasons - unbroken.reasons)


def _rank(verdict: str) -> int:
    return RANKS.index(verdict) if verdict in RANKS else len(RANKS)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--most", type=int, default=1, help="of each kind in each controller")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="only controllers whose name holds this text")
    parser.add_argument("--kind", default="", help="only kinds that hold this text")
    parser.add_argument("--rows", type=Path, help="write every row as a line of JSON")
    options = quick.parsed(parser, only=lambda: "weighing", kind=lambda: "early return")
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as where:
        rows = measure(Path(where), options)
    return report(rows, time.monotonic() - begin)


def measure(where: Path, options: argparse.Namespace) -> list[Row]:
    chosen = [item for item in cases() if options.only in item.name]
    for case in chosen:
        lay_out(case, where / case.name)
    with ThreadPoolExecutor(options.jobs) as pool:
        nominals = list(pool.map(lambda item: run(item, where / item.name), chosen))
        wanted: list[tuple[Case, Breakage, Outcome, Path]] = []
        most = {kind: options.most * (2 if kind == MOVED else 1) for kind in KINDS}
        for turn, (case, nominal) in enumerate(zip(chosen, nominals, strict=True)):
            print(f"{case.name}: {nominal.verdict}", file=sys.stderr)
            if nominal.verdict not in ("complete", "partial") or nominal.mission is None:
                raise SystemExit(f"{case.name} does not work unbroken: {nominal.words}")
            unbroken = unbroken_of(where / case.name)
            result = spread(list(breakages(unbroken)), most, turn)
            result += spread(
                list(refactorings(unbroken)), dict.fromkeys(REFACTORINGS, options.most), turn
            )
            for number, breakage in enumerate(result):
                if options.kind in breakage.kind:
                    folder = where / f"{case.name}-{number}"
                    wanted.append((case, breakage, nominal, folder))
        rows = []
        for row in pool.map(lambda item: _run_broken(*item), wanted):
            rows.append(row)
            if options.rows:
                with options.rows.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(_row_data(row)) + "\n")
        return rows


def _row_data(row: Row) -> dict[str, Any]:
    return {
        "case": row.case,
        "kind": row.breakage.kind,
        "what": row.breakage.what,
        "lacks": row.lacks,
        "verdict": row.verdict,
        "words": row.words,
        "is_miss": row.is_miss,
        "is_false_alarm": row.is_false_alarm,
    }


def report(rows: Sequence[Row], seconds: float) -> int:
    """Print what was found, and return the exit code."""
    heads = ("kind", "n", "carried out", *RANKS, "other", "missed", "false alarms")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for kind in (*KINDS, *REFACTORINGS):
        print(_line(kind, [item for item in rows if item.breakage.kind == kind]))
    broken = [item for item in rows if item.breakage.kind in KINDS]
    refactored = [item for item in rows if item.breakage.kind in REFACTORINGS]
    print(_line("all breakages", broken))
    print(_line("all refactorings", refactored))
    for title, chosen in (
        ("missed", [item for item in rows if item.is_miss and item.breakage.kind in KINDS]),
        ("false alarms", [item for item in rows if item.is_false_alarm]),
        ("refactorings that changed the mission", [item for item in refactored if item.lacks]),
    ):
        print(f"\n{title}: {len(chosen)}")
        for row in chosen:
            print(f"- {row.case}, {row.breakage.kind}: {row.breakage.what}")
            print(f"  mission: {row.lacks or 'carried out'}; verdict: {row.words or row.verdict}")
    failed = [item for item in broken if item.lacks]
    done = [item for item in rows if not item.lacks]
    noticed = sum(not item.is_miss for item in failed) / max(len(failed), 1)
    false = sum(item.is_false_alarm for item in done)
    print(
        f"\n{len(broken)} breakages, {len(failed)} missions not carried out, {noticed:.1%} noticed"
    )
    print(f"{len(done)} missions carried out, {false} false alarms; {seconds:.0f} s")
    is_good = noticed >= LEAST_NOTICED and not false and not any(item.lacks for item in refactored)
    return 0 if is_good else 1


def _line(kind: str, rows: Sequence[Row]) -> str:
    counts = Counter(row.verdict if row.verdict in RANKS else "other" for row in rows)
    cells = [
        *(str(len(rows)), str(sum(not row.lacks for row in rows))),
        *(str(counts[rank]) for rank in (*RANKS, "other")),
        str(sum(row.is_miss for row in rows)),
        str(sum(row.is_false_alarm for row in rows)),
    ]
    return f"| {kind} | {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
