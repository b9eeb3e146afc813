"""A run whose file is replaced while it starts, as an editor saves."""

import os
import threading
from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tracerisk.pipeline.run.ended_run import ProcessEnd, replaced_file


def end_of(path: Path, **more) -> ProcessEnd:
    return ProcessEnd(
        1, last_line=f"PermissionError: [Errno 13] Permission denied: '{path}'", **more
    )


def test_only_a_file_of_the_controller_that_can_be_read_was_replaced(tmp_path):
    file = tmp_path / "c.py"
    file.write_text("")
    assert replaced_file(end_of(file), tmp_path) == file
    assert replaced_file(end_of(file, has_begun=True), tmp_path) is None
    assert replaced_file(end_of(tmp_path / "gone.py"), tmp_path) is None
    assert replaced_file(end_of(Path("/etc/hostname")), tmp_path) is None
    assert replaced_file(ProcessEnd(1, last_line="ValueError: no"), tmp_path) is None


@pytest.mark.slow  # it hangs on when a save meets the start of a process
@pytest.mark.skipif(os.name != "posix", reason="the sandbox needs Linux")
def test_a_run_goes_well_although_its_file_is_saved_while_it_starts(example):
    example.write("c.py", quick_controller())
    example.write(".git/HEAD", "ref: refs/heads/main\n")  # so that files are let in one by one
    over = threading.Event()

    def save() -> None:
        for _ in range(8):
            if over.wait(0.05):
                break
            copy = example.folder / "copy"
            copy.write_bytes((example.folder / "c.py").read_bytes())
            copy.replace(example.folder / "c.py")

    thread = threading.Thread(target=save)
    thread.start()
    outcome = example.run("run", "c.py", "--diff")
    over.set()
    thread.join()
    assert outcome.code == 0, outcome.err
