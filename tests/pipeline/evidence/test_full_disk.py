"""A campaign on a full disk says so, makes nothing of what it could not record, and goes on later."""

import os
import subprocess
import sys

import pytest

from tests.pipeline.evidence.test_interrupted import ALONE as COMMAND
from tests.pipeline.evidence.test_interrupted import FORKED, settled

# The disk of the controller gets full when the first cells have come.
FILLED = """\
import os, pathlib, sys
from tracerisk.cli import main
from tracerisk.pipeline.evidence import campaign, workers
campaign.MOST_IN_BATCH = 2
sys.path.insert(0, os.environ.pop("FORKED"))
from tests.commands import ForkedWorkers
workers._CONTEXT = ForkedWorkers()
batches_done = campaign._batches_done
def fill(*arguments):
    for number, done in enumerate(batches_done(*arguments)):
        if number == 1:
            with open("filler", "wb", buffering=0) as file:
                try:
                    while file.write(b"x" * 512):
                        pass
                except OSError:
                    pass
        yield done
campaign._batches_done = fill
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def small_disk(tmp_path):
    """Return a function that makes a disk of so many bytes, where the user may mount one."""
    disks = []

    def made(size: int):
        disk = tmp_path / f"disk{len(disks)}"
        disk.mkdir()
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)],
            capture_output=True,
            check=False,
        )
        if done.returncode != 0:
            pytest.skip("no disk can be mounted here")
        disks.append(disk)
        return disk

    yield made
    for disk in disks:
        subprocess.run(["umount", "--lazy", str(disk)], check=False)


def test_without_room_for_a_recording_nothing_is_said_of_the_controller(
    small_disk, tmp_path, example_in, quick
):
    folder = settled(example_in(tmp_path / "controller"), quick)
    disk = small_disk(300 * 1024)
    done = folder.run(*COMMAND, environment={"TMPDIR": str(disk)})
    assert done.code == 4
    assert f"the disk that holds {disk}/tracerisk-" in done.err
    assert "TMPDIR" in done.err
    assert "Traceback" not in done.err
    assert not (folder.folder / "tracerisk.evidence").exists()
    assert not list(disk.iterdir())


@pytest.mark.slow
def test_what_was_tried_before_the_disk_was_full_is_kept(small_disk, whole, example_in, quick):
    folder = settled(example_in(small_disk(120 * 1024) / "controller"), quick)
    done = subprocess.run(
        [sys.executable, "-c", FILLED, *COMMAND],
        cwd=folder.folder,
        env={**os.environ, **FORKED},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "cannot be written: No space left on device" in done.stderr
    assert "Traceback" not in done.stderr
    (journal,) = (folder.folder / ".tracerisk_cache").glob("evidence-*")
    assert journal.read_text().count('"unit"') >= 2
    (folder.folder / "filler").unlink()
    assert folder.run(*COMMAND).code == 0
    assert folder.read("tracerisk.evidence") == whole
