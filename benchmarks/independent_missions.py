"""Run independent controllers, edits that break their missions, and edits that change nothing.

    python benchmarks/independent_missions.py [--set a] [--jobs 2] [--only TEXT] [--quick]

Each folder of `benchmarks/missions` is a set: controllers with their scenarios, written by people
who had seen neither this code nor its findings, and edits of them in `edits.json`. Before the first
run each edit was judged by the recorded physics and by goals that its author had declared; neither
knows anything of verdict or outcome. An edit is noticed where the run has another verdict, by a
reason that the unbroken run has not, or where `diff` names a difference of the outcome.
Of each harmless edit the mission's probability of failure is compared, too: the law of refactoring
allows no other figure. Prints a table by category; `--rows FILE` writes each row. Exits 1 where
fewer than 95 % of the broken missions are noticed, or more than 2 % of the harmless edits are.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import quick

from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import kept_outcome
from tracerisk.common.outcome.outcome import Outcome
from tracerisk.common.verdict import Verdict
from tracerisk.pipeline.trace.kept_verdict import verdict_of_data
from tracerisk.prm.review.change_records import RunVerdicts

SETS = Path(__file__).parent / "missions"
RANKS = ("complete", "partial", "faulted", "stuck")
LEAST_NOTICED, MOST_ALARMS = 0.95, 0.02
SAME_FIGURE = 0.01
LIMITS = ("--cpu-limit", "90", "--wall-limit", "300", "--stall-limit", "20")


@dataclass(frozen=True)
class Edit:
    """One edit of a controller, as its author described it before any run."""

    id: str
    base: str
    """The folder of the controller that it changes."""
    kind: str
    """`broken` or `harmless`."""
    category: str
    what: str
    """What was changed, in a line."""
    why: str
    """What of the mission fails; empty for a harmless edit."""
    files: Mapping[str, list[list[Any]]]
    """By file the replaced lines: first, last (exclusive, from 0) and the new text."""


@dataclass(frozen=True)
class Mission:
    """A controller of a set."""

    name: str
    script: str
    options: tuple[str, ...]
    folder: Path


@dataclass(frozen=True)
class Ran:
    """What a run left: its verdict, also as the lock keeps it, and its outcome."""

    verdict: str
    words: str
    judgement: Verdict | None
    outcome: Outcome | None
    p_failure: float | None = None
    """The mission's probability of failure; `None` where there is none."""


@dataclass(frozen=True)
class Row:
    """An edit with what the tool says of it."""

    id: str
    kind: str
    category: str
    what: str
    why: str
    verdict: str
    by_verdict: str
    """The new reason; empty for none."""
    by_outcome: tuple[str, ...]
    """What `diff` names."""
    figure: float | None = None
    """The mission's probability of failure over that of the unbroken run."""

    @property
    def is_noticed(self) -> bool:
        return bool(self.by_verdict or self.by_outcome)


def missions(folder: Path) -> tuple[list[Mission], list[Edit]]:
    """Return the controllers of a set, and the edits of them."""
    data = json.loads((folder / "edits.json").read_text(encoding="utf-8"))
    bases = [
        Mission(base["name"], base["script"], tuple(base["options"]), folder / base["name"])
        for base in data["bases"]
    ]
    return bases, [Edit(**edit) for edit in data["edits"]]


def edited(text: str, changes: Sequence[Sequence[Any]]) -> str:
    """Return a text with some of its lines replaced."""
    lines = text.splitlines(keepends=True)
    for first, last, new in sorted(changes, key=lambda change: -change[0]):
        lines[first:last] = [new]
    return "".join(lines)


def lay_out(mission: Mission, folder: Path, edit: Edit | None = None) -> None:
    """Copy a controller into a folder, as the root of a project, with an edit."""
    shutil.copytree(mission.folder, folder)
    if not any((folder / name).exists() for name in ("pyproject.toml", "package.xml", "setup.py")):
        (folder / "pyproject.toml").write_bytes(b"")
    for name, changes in (edit.files if edit else {}).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        path.write_text(edited(before, changes), encoding="utf-8")


def run(mission: Mission, folder: Path) -> Ran:
    """Run a controller that lies in a folder, as a user does, and read the lock."""
    command = [sys.executable, "-m", "tracerisk", "run", mission.script, *mission.options]
    done = subprocess.run(
        [*command, *LIMITS, "--json"], cwd=folder, capture_output=True, text=True, check=False
    )
    try:
        loads = json.loads(done.stdout)
    except ValueError:
        return Ran("internal error", done.stderr[-300:], None, None)
    entry: dict[str, Any] = {}
    # It stands at the root of the project, which may be a package of the workspace.
    for lock in folder.rglob("tracerisk.lock"):
        controllers: dict[str, Any] = json.loads(lock.read_text(encoding="utf-8"))["controllers"]
        entry = next((known["trace"] for known in controllers.values()), {})
    given: Any = loads.get("verdict") or entry.get("verdict", {})
    verdict: dict[str, Any] = {"kind": given} if isinstance(given, str) else given
    error: dict[str, Any] = loads.get("error") or {}
    kind = verdict.get("kind") or str(error.get("code") or "refused")
    open_reasons = [item for item in verdict.get("reasons", ()) if not item.get("accepted")]
    words = "; ".join(open_reason["words"] for open_reason in open_reasons) or str(
        error.get("message", "")
    )
    assessed: dict[str, Any] = (loads.get("assessment") or {}).get("mission") or {}
    judgement, outcome = verdict_of_data(entry.get("verdict")), kept_outcome(entry)
    return Ran(kind, words, judgement, outcome, assessed.get("failure_probability"))


def judged(edit: Edit, base: Ran, now: Ran) -> Row:
    """Return what the tool says of an edit, against the unbroken run."""
    by_verdict = ""
    before, after = base.judgement, now.judgement
    broke = RunVerdicts(before, after).broke if before is not None and after is not None else ()
    if rank(now.verdict) > rank(base.verdict) or broke:
        words = "; ".join(reason.words for reason in broke) or now.words
        by_verdict = f"{now.verdict}: {words[:200]}"
    by_outcome: tuple[str, ...] = ()
    if base.outcome is not None and now.outcome is not None:
        by_outcome = outcome_changes(base.outcome, now.outcome).sentences
    return Row(
        *(edit.id, edit.kind, edit.category, edit.what, edit.why, now.verdict),
        by_verdict,
        by_outcome,
        now.p_failure / base.p_failure if base.p_failure and now.p_failure else None,
    )


def rank(verdict: str) -> int:
    return RANKS.index(verdict) if verdict in RANKS else len(RANKS)


def rows_of(folder: Path, where: Path, options: argparse.Namespace) -> Iterator[Row]:
    """Run a set, and yield its rows."""
    bases, edits = missions(folder)
    bases = [base for base in bases if options.only in base.name]
    if options.quick:
        bases = bases[:1]
    for base in bases:
        lay_out(base, where / base.name)
    with ThreadPoolExecutor(options.jobs) as pool:
        done = pool.map(lambda base: run(base, where / base.name), bases)
        sound = dict(zip([base.name for base in bases], done, strict=True))
        for name, ran in sound.items():
            print(f"{name}: {ran.verdict}; {ran.words[:150]}", file=sys.stderr)
        by_name = {base.name: base for base in bases}
        chosen = [edit for edit in edits if edit.base in by_name]
        if options.quick:
            chosen = [*chosen[:1], *(edit for edit in chosen if edit.kind == "harmless")][:2]

        def one(edit: Edit) -> Row:
            place = where / f"{edit.base}-{edit.id}"
            mission = by_name[edit.base]
            lay_out(mission, place, edit)
            row = judged(edit, sound[edit.base], run(mission, place))
            shutil.rmtree(place)
            return row

        yield from pool.map(one, chosen)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--set", default="", help="only this set")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="only controllers whose name holds this text")
    parser.add_argument("--rows", type=Path, help="write every row as a line of JSON")
    if not SETS.is_dir():
        quick.skip(f"{SETS} is not there: the sets of missions are no part of this checkout")
    # One controller with two edits.
    options = quick.parsed(parser)
    begin = time.monotonic()
    known = (folder for folder in sorted(SETS.iterdir()) if folder.is_dir())
    sets = [folder for folder in known if options.set in ("", folder.name)]
    is_good = True
    for folder in sets[:1] if options.quick else sets:
        with tempfile.TemporaryDirectory() as where:
            rows = []
            for row in rows_of(folder, Path(where), options):
                rows.append(row)
                if options.rows:
                    with options.rows.open("a", encoding="utf-8") as stream:
                        stream.write(json.dumps({"set": folder.name, **asdict(row)}) + "\n")
        is_good &= report(folder.name, rows)
    print(f"{time.monotonic() - begin:.0f} s")
    return 0 if is_good or options.quick else 1


def report(name: str, rows: Sequence[Row]) -> bool:
    """Print what was found of a set, and return whether it meets the bar."""
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.kind, row.category].append(row)
    heads = ("edit", "n", "by verdict", "by outcome", "noticed")
    print(f"\nset {name}\n| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for (kind, category), group in sorted(groups.items()):
        print(_line(f"{kind}: {category}", group))
    broken = [row for row in rows if row.kind == "broken"]
    harmless = [row for row in rows if row.kind != "broken"]
    print(_line("all that break the mission", broken))
    print(_line("all harmless", harmless))
    for title, shown in (
        ("not noticed", [row for row in broken if not row.is_noticed]),
        ("false alarms", [row for row in harmless if row.is_noticed]),
    ):
        print(f"\n{title}: {len(shown)}")
        for row in shown:
            print(f"- {row.id} ({row.category}): {row.what}")
            print(f"  {row.why or row.by_verdict or '; '.join(row.by_outcome)}")
    noticed = sum(row.is_noticed for row in broken)
    alarms = sum(row.is_noticed for row in harmless)
    share, false = noticed / max(len(broken), 1), alarms / max(len(harmless), 1)
    print(f"\n{name}: {noticed} of {len(broken)} broken missions noticed ({share:.1%});")
    print(f"{alarms} of {len(harmless)} harmless edits noticed ({false:.1%});")
    figures = [row.figure for row in harmless if row.figure is not None]
    same = sum(abs(figure - 1.0) <= SAME_FIGURE for figure in figures)
    print(f"{same} of {len(figures)} with a figure have the same within {SAME_FIGURE:.0%}")
    return share >= LEAST_NOTICED and false <= MOST_ALARMS


def _line(name: str, rows: Sequence[Row]) -> str:
    counts = (
        len(rows),
        sum(bool(row.by_verdict) for row in rows),
        sum(bool(row.by_outcome) for row in rows),
        sum(row.is_noticed for row in rows),
    )
    return f"| {name} | {' | '.join(map(str, counts))} |"


if __name__ == "__main__":
    sys.exit(main())
