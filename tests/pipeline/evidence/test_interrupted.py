"""A campaign that is interrupted, at any moment and however, goes on and ends with the same bytes."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.safety_engineers.test_evidence import HARDWARE

# Batches of a few cells, and a moment in the middle of writing the file.
CAMPAIGN = """\
import os, pathlib, sys, time
from tracerisk.cli import main
from tracerisk.pipeline.evidence import campaign, workers
campaign.MOST_IN_BATCH = 2
if "FORKED" in os.environ:
    sys.path.insert(0, os.environ.pop("FORKED"))
    from tests.commands import ForkedWorkers
    workers._CONTEXT = ForkedWorkers()
dump = campaign.dump_evidence
def slow(found):
    if "WRITING" in os.environ:
        pathlib.Path(os.environ["WRITING"]).touch()
        time.sleep(3.0)
    return dump(found)
campaign.dump_evidence = slow
sys.exit(main(["evidence", "controller.py", "--cells", "4", "-q", "-j", sys.argv[1]]))
"""
FORKED = {"FORKED": str(Path(__file__).parents[3])}
"""With it, workers are forked, which need not import everything anew."""
ALONE = ("evidence", "controller.py", "--cells", "4", "-j", "1", "-q")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
MOMENTS = ("start", "nominal run", "first batch", "between batches", "writing")
LONGEST_S = 120.0


def settled(folder, quick):
    folder.write("controller.py", quick())
    folder.write("one.yaml", HARDWARE)
    folder.write("pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\n')
    return folder


def begun(
    folder,
    temporary: Path,
    writing: Path | None = None,
    workers: int = 2,
    *,
    is_forked: bool = False,
) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "TMPDIR": str(temporary), "TRACERISK_TEST_MARK": str(temporary)}
    if writing is not None:
        environment["WRITING"] = str(writing)
    if is_forked:
        environment |= FORKED
    return subprocess.Popen(
        [sys.executable, "-c", CAMPAIGN, str(workers)],
        cwd=folder.folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def ours(temporary: Path) -> list[str]:
    """Return the processes of campaigns with this folder for temporary files."""
    found = []
    for each in Path("/proc").glob("[0-9]*/environ"):
        try:
            if f"TRACERISK_TEST_MARK={temporary}".encode() in each.read_bytes().split(b"\0"):
                found.append(each.parent.name)
        except OSError:
            continue
    return found


@pytest.mark.parametrize(
    ("moment", "number", "workers"),
    [
        ("between batches", signal.SIGKILL, 1),
        *(
            pytest.param(moment, number, 2, marks=pytest.mark.slow)
            for moment in MOMENTS
            for number in SIGNALS
        ),
    ],
)
def test_it_goes_on_and_leaves_nothing(moment, number, workers, whole, tmp_path, example_in, quick):
    folder = settled(example_in(tmp_path / "controller"), quick)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    writing = tmp_path / "writing"
    cache = folder.folder / ".tracerisk_cache"
    reached = {
        "start": lambda: True,
        "nominal run": lambda: any(temporary.glob("tracerisk-evidence-*")),
        "first batch": lambda: any(temporary.glob("*/worker-*/tracerisk-cells-*")),
        "between batches": lambda: any(each.stat().st_size for each in cache.glob("evidence-*")),
        "writing": writing.exists,
    }[moment]
    at = writing if moment == "writing" else None
    process = begun(folder, temporary, at, workers, is_forked=workers == 1)
    deadline = time.monotonic() + LONGEST_S
    while not reached() and time.monotonic() < deadline:
        assert process.poll() is None, "it ended before the moment came"
        time.sleep(0.01)
    process.send_signal(number)
    # Python itself may be starting yet, and then knows no better end.
    assert process.wait() != 0
    while ours(temporary) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not ours(temporary)
    if number != signal.SIGKILL:
        assert not list(temporary.iterdir())

    again = folder.run(*ALONE[:-1], environment={"TMPDIR": str(temporary)})
    assert again.code == 0, again.err
    if moment == "between batches":
        size = r"6 failures to try, \d of them now: 6 are drawn \(4 were asked for, and each unit"
        assert re.search(size, again.err)
    assert folder.read("tracerisk.evidence") == whole
    assert not list(temporary.iterdir())
    assert not list(cache.glob("evidence-*"))
    assert not list(folder.folder.glob(".*.tmp"))


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_no_more_than_its_batch(whole, tmp_path, example_in, quick):
    folder = settled(example_in(tmp_path / "controller"), quick)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    process = begun(folder, temporary, is_forked=True)
    deadline = time.monotonic() + LONGEST_S
    while not any(temporary.glob("*/worker-*/tracerisk-cells-*")) and time.monotonic() < deadline:
        time.sleep(0.01)
    # What else it has started runs another program.
    children = Path("/proc", str(process.pid), "task", str(process.pid), "children").read_text()
    program = Path("/proc", str(process.pid), "cmdline").read_bytes()
    workers = [
        int(each)
        for each in children.split()
        if Path("/proc", each, "cmdline").read_bytes() == program
    ]
    assert len(workers) == 2
    os.kill(workers[0], signal.SIGKILL)
    assert process.wait() == 0
    assert folder.read("tracerisk.evidence") == whole
    assert not list(temporary.iterdir())
