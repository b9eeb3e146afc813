"""Ask the DTMCs and CTMCs of the PRISM benchmark suite what it asks, and print the table.

    python benchmarks/prism_suite.py --models prism-benchmarks/models [--most-states 20000]

The suite is M. Kwiatkowska, G. Norman, D. Parker, "The PRISM Benchmark Suite" (QEST 2012),
github.com/prismmodelchecker/prism-benchmarks; it is not part of this repository. Each folder of a
model says in `models.csv` which constants make which number of states, and in each file of
properties, as comments, what PRISM found (`RESULT`). A constant that a property leaves open is
`--open` (1). Models of more states by `models.csv` than `--most-states` are counted, not read.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import re
import resource
import signal
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType

import quick

from tracerisk.errors import InputError, TraceRiskError
from tracerisk.prm.other_models.formats.prism.prism_reader import read_prism_model
from tracerisk.prm.other_models.properties import Answer, PropertyFile, ask, parse_properties

QUICK_SUITE = {
    "dtmcs/coin/models.csv": "model_file,model_consts,states\ncoin.pm,,3\n",
    "dtmcs/coin/coin.pm": """\
dtmc
module coin
  side : [0..2] init 0;
  [] side = 0 -> 0.25 : (side' = 1) + 0.75 : (side' = 2);
  [] side > 0 -> true;
endmodule
""",
    "dtmcs/coin/heads.pctl": "// RESULT: 0.25\nP=? [ F side = 1 ]\n",
}

LONGEST_S = 60
MOST_BYTES = 2**31
KINDS = ("dtmcs", "ctmcs")
PROPERTIES = (".pctl", ".csl", ".props")
_RESULT = re.compile(r"RESULT(?: \((?P<constants>[^)]*)\))?: (?P<value>\S+)")


class TookTooLongError(BaseException):
    """What is not done in time."""


@dataclass(frozen=True)
class Model:
    """A model of the suite with its constants."""

    path: Path
    constants: dict[str, float]
    states: int


@dataclass(frozen=True)
class Row:
    """A property of a model: what it is here, what the suite has, and how long it took."""

    model: str
    constants: str
    question: str
    found: str
    published: str
    seconds: float


def models(folder: Path) -> Iterator[Model]:
    """Yield what `models.csv` of each folder lists."""
    for kind in KINDS:
        for table in sorted((folder / kind).glob("*/models.csv")):
            with table.open(encoding="utf-8") as lines:
                for row in csv.DictReader(lines):
                    path = table.parent / row["model_file"]
                    states = row["states"]
                    number = int(states) if states.isdigit() else sys.maxsize
                    if path.is_file():  # the suite lists some that it does not hold
                        yield Model(path, _constants(row["model_consts"]), number)


def _constants(text: str) -> dict[str, float]:
    pairs = (part.partition("=") for part in text.split(",") if "=" in part)
    return {name.strip(): float(value) for name, _, value in pairs}


def _typed(constants: dict[str, float]) -> dict[str, int | float | bool]:
    return {
        name: int(constant) if constant.is_integer() else constant
        for name, constant in constants.items()
    }


def published(text: str, constants: dict[str, float]) -> str:
    """Return what the comments of a file of properties say for these constants."""
    for match_ in _RESULT.finditer(text):
        given = _constants(match_["constants"] or "")
        if all(constants.get(name) == value for name, value in given.items()):
            return match_["value"]
    return ""


def asked(task: tuple[Model, float]) -> list[Row]:
    """Return the rows of one model; it is read once."""
    model, open_value = task
    name = model.path.parent.name if "poll" not in model.path.stem else model.path.stem
    if model.path.stem.startswith(name):
        name = model.path.stem
    said = ", ".join(f"{key} = {value:g}" for key, value in model.constants.items())
    files = sorted(path for path in model.path.parent.iterdir() if path.suffix in PROPERTIES)
    began = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        text = model.path.read_text(encoding="utf-8")
        chain = read_prism_model(text, file=model.path.name, constants=_typed(model.constants))
    except (TraceRiskError, TookTooLongError, MemoryError) as error:
        seconds = time.process_time() - began
        return [Row(name, said, "", _words(error), "", seconds)]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    read = time.process_time() - began
    rows = []
    for file in files:
        text = file.read_text(encoding="utf-8")
        expected = published(text, model.constants)
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
        question = file.stem
        try:
            given = parse_properties(text, file.name)
            opened = [constant for constant, value in given.constants.items() if value is None]
            question += "".join(f", {word} = {open_value:g}" for word in opened)
            values = _typed(dict.fromkeys(opened, open_value))
            for item in given.properties:
                answer = ask(chain, _one(given, item), values)[0]
                rows.append(
                    Row(name, said, question, _shown(answer), expected, time.process_time() - began)
                )
        except (TraceRiskError, TookTooLongError, MemoryError) as error:
            seconds = time.process_time() - began
            rows.append(Row(name, said, question, _words(error), expected, seconds))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
    return [Row(name, said, f"{len(chain.states)} states", "read", "", read), *rows]


def _one(given: PropertyFile, each: object) -> PropertyFile:
    return replace(given, properties=tuple(one for one in given.properties if one is each))


def _shown(found: Answer) -> str:
    if found.holds is not None:
        return str(found.holds).lower()
    return repr(found.greatest)


def _words(error: BaseException) -> str:
    if isinstance(error, TookTooLongError):
        return f"not done after {LONGEST_S} s"
    if isinstance(error, MemoryError):
        return f"more than {MOST_BYTES // 2**20} MB"
    what = error.message if isinstance(error, InputError) else str(error)
    return f"refused: {what}"


def difference(row: Row) -> float | None:
    """Return the relative difference of a row from the suite; `None` where it is unknown."""
    try:
        value, expected = float(row.found), float(row.published)
    except ValueError:
        return None if not row.published or row.found != row.published else 0.0
    return abs(value - expected) / abs(expected) if expected else abs(value)


def _too_long(_signal: int, _frame: FrameType | None) -> None:
    raise TookTooLongError


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    signal.signal(signal.SIGPROF, _too_long)


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--models", type=Path, help="the folder `models`")
    parser.add_argument("--most-states", type=int, default=20_000)
    parser.add_argument("--open", type=float, default=1.0, help="what a property leaves open")
    options = quick.parsed(parser, models=lambda: quick.folder(QUICK_SUITE))
    if options.models is None:
        parser.error("give --models DIR")
    every = sorted(models(options.models), key=lambda model: (model.path.parent, model.states))
    chosen = [model for model in every if model.states <= options.most_states]
    rows: list[Row] = []
    print("| model | constants | property | here | published | difference | s |")
    print("|---|---|---|---|---|---|---|")
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context, initializer=_limit) as pool:
        for result in pool.map(asked, [(model, options.open) for model in chosen]):
            for row in result:
                far = difference(row)
                far_text = "" if far is None else f"{far:.1e}"
                print(
                    f"| {row.model} | {row.constants} | {row.question} | {row.found} | "
                    f"{row.published} | {far_text} | {row.seconds:.2f} |",
                    flush=True,
                )
            rows += result
    answered = [row for row in rows if row.question and row.found != "read"]
    solved = [row for row in answered if not row.found.startswith(("refused", "not", "more"))]
    known = [value for value in map(difference, answered) if value is not None]
    unread = sum(1 for row in rows if not row.question)
    print(
        f"\n{len(chosen)} of {len(every)} models have at most {options.most_states} states, "
        f"{unread} of them refused; {len(solved)} of {len(answered)} properties of the others "
        f"answered; {len(known)} compared with published values, the greatest relative difference "
        f"is {max(known, default=0.0):.1e}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
