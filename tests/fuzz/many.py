"""Give the readers a number of inputs that were made of whole examples, and report what breaks.

    python tests/fuzz/many.py --inputs 1000000 --jobs 2 [--readers NAME ...] [--seed N] [--keep DIR]

The inputs are shared out evenly over the readers; one that takes a process each gets fewer. An input must end in a result or in an error of
ours, within 10 s of processor time and 1 GB of further memory; each that does not is printed with the last line of
its traceback and, with `--keep`, written to a folder. Seed, reader and number make an input again.
"""

import argparse
import multiprocessing
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

sys.path.insert(0, str(Path(__file__).parent))

from readers import READERS

from tracerisk.errors import TraceRiskError

LONGEST_S = 10
MOST_BYTES = 2**30
BATCH = 1000

# What readers tend to stumble over, put into whole examples.
TOKENS = [
    *(b"1e400", b"-1e999", b"1e-320", b"nan", b"NaN", b"Infinity", b"0", b"-1", b"1e308"),
    *(b"9" * 20, b"9" * 350, b"\x00", b"\xff", b"\r\n", b"\r", b"\x0c", b"\xef\xbb\xbf"),
    *(b"\xe2\x80\xae", b"{", b"}", b"(", b")", b"[", b"]", b"<", b">", b";", b",", b":"),
    *(b'"', b"'", b"#", b"!", b":=", b"=", b"..", b"../../etc/passwd", b"*a", b"&a [*a]", b"!!set"),
    *(b"? ", b"<<: ", b"!!binary", b"0x", b"1_0", b"2001-99-99", b"|", b"%", b"---"),
]
LONG_TOKENS = [
    *(b"9" * 5000, b"0." + b"0" * 5000 + b"1", b"(" * 3000, b"[" * 100_000, b'{"a":' * 20_000),
    *(b"-" * 3000, b"!" * 3000, b"<a>" * 3000, b"- " * 2000),
]


class TookTooLongError(BaseException):
    """An input that a reader has not done with in time; no reader may catch it."""


@dataclass(frozen=True)
class Finding:
    """An input that ended a reader with something other than a result or an error of ours."""

    name: str
    """Of the reader."""
    number: int
    """Of the input."""
    words: str


def mutated(name: str, seed: int, number: int) -> bytes:
    """Return a whole example with pieces taken out, doubled, or replaced by a token or noise."""
    chance = random.Random(f"{seed} {name} {number}")
    data = chance.choice(READERS[name].examples)
    for _ in range(chance.randint(1, 4)):
        start = chance.randint(0, len(data))
        end = chance.randint(start, min(len(data), start + 40))
        kind = chance.randrange(6)
        if kind == 0:
            piece = b""
        elif kind == 1:
            piece = data[start:end] * 2
        elif kind == 2:
            piece = chance.randbytes(chance.randint(0, 8))
        elif kind == 3:  # a piece of the same text at another place
            other = chance.randint(0, len(data))
            piece = data[other : other + chance.randint(1, 40)]
        else:
            piece = chance.choice(LONG_TOKENS if chance.randrange(16) == 0 else TOKENS)
        data = data[:start] + piece + data[end:]
    return data


def accepts_or_refuses(name: str, data: bytes, folder: Path) -> None:
    """Read an input; an error of ours that says something is as good as a result."""
    try:
        READERS[name].read(data, folder)
    except TraceRiskError as error:
        if not str(error):
            raise AssertionError("an error without words") from error


def _too_long(_signal: int, _frame: FrameType | None) -> None:
    raise TookTooLongError(f"not done after {LONGEST_S} s")


def _limit() -> None:
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MOST_BYTES, used + MOST_BYTES))
    signal.signal(signal.SIGPROF, _too_long)


def _batch(task: tuple[str, int, range]) -> list[Finding]:
    name, seed, numbers = task
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            data = mutated(name, seed, number)
            signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
            try:
                accepts_or_refuses(name, data, Path(folder))
            except (Exception, TookTooLongError) as error:  # noqa: BLE001 - whatever it is
                steps = traceback.extract_tb(error.__traceback__)
                place = next(
                    (each for each in reversed(steps) if each.name != "_too_long"), steps[-1]
                )
                words = (
                    f"{type(error).__name__}: {str(error)[:200]} ({place.filename}:{place.lineno})"
                )
                found.append(Finding(name, number, words))
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
    return found


def fuzzed(names: Sequence[str], inputs: int, *, seed: int, jobs: int) -> list[Finding]:
    """Return what `inputs` inputs of each of some readers found."""
    counts = {name: -(-inputs // READERS[name].one_in) for name in names}
    tasks = [
        (name, seed, range(first, min(first + BATCH, counts[name])))
        for first in range(0, inputs, BATCH)
        for name in names
        if first < counts[name]
    ]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_limit) as pool:
        return [
            finding for batch in _with_progress(pool.map(_batch, tasks), tasks) for finding in batch
        ]


def _with_progress(
    batches: Iterable[list[Finding]], tasks: Sequence[tuple[str, int, range]]
) -> Iterable[list[Finding]]:
    done, began = 0, time.monotonic()
    for batch, (_, _, numbers) in zip(batches, tasks, strict=True):
        done += len(numbers)
        for finding in batch:
            print(f"{finding.name} {finding.number}: {finding.words}", flush=True)  # noqa: T201
        seconds = time.monotonic() - began
        print(f"{done} inputs, {seconds:.0f} s", file=sys.stderr, flush=True)  # noqa: T201
        yield batch


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000, help="over all readers")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--readers", nargs="+", choices=READERS, default=list(READERS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for the inputs that found something")
    options = parser.parse_args()
    each = -(-options.inputs // len(options.readers))
    found = fuzzed(options.readers, each, seed=options.seed, jobs=options.jobs)
    if options.keep is not None:
        for finding in found:
            kept = options.keep / finding.name / str(finding.number)
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes(mutated(finding.name, options.seed, finding.number))
    print(f"{each * len(options.readers)} inputs, {len(found)} findings")  # noqa: T201
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
