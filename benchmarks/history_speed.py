"""How long `tracerisk history` takes over many commits of a made repository.

    python benchmarks/history_speed.py [--commits N] [--repeat N]

One annotated controller, and in each of N commits (200) another figure in its source and another
lock. Each figure is the median of a few runs of the whole command in its own process: wall time,
and processor time, which the load of the machine changes less. What is asked of it: 200 commits
take less than 10 s.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import quick
from check_speed import commit, make, median

NAME = "controller.py"


def grow(folder: Path, commits: int) -> None:
    """Make a repository with so many commits, each with another figure."""
    make(folder, [NAME])
    source, lock = folder / NAME, folder / "tracerisk.lock"
    first, digests = source.read_bytes(), lock.read_bytes()
    commit(folder)
    for number in range(1, commits):
        figure = f"{9.5e-08 * 1.02**number:.3e}".encode()  # less would count as noise
        source.write_bytes(first.replace(b"9.5e-08", figure))
        lock.write_bytes(digests.replace(b"9.5e-08", figure))
        commit(folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--commits", type=int, default=200)
    parser.add_argument("--repeat", type=int, default=5)
    options = quick.parsed(parser, commits=lambda: 3, repeat=lambda: 1)
    history = [sys.executable, "-m", "tracerisk", "history"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        grow(folder, options.commits)
        done = subprocess.run([*history, "--json"], cwd=folder, check=True, capture_output=True)
        rows = json.loads(done.stdout)["controllers"][NAME]["commits"]
        assert len(rows) == options.commits, len(rows)
        print(f"{'wall':>9} {'processor':>9}  [s, medians]")
        for words in ([], ["--svg", "history.svg"]):
            times = median([*history, *words], folder, options.repeat)
            print(f"{times}  history {' '.join(words)} of {len(rows)} commits".rstrip())


if __name__ == "__main__":
    main()
