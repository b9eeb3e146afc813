import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tracerisk.errors import LogError
from tracerisk.twin.recording.samples import SampleHeader, SampleWriter, read_samples

HEADER = SampleHeader("arm", "bench", 2_000_000, ("a", "b"), ("j1",), ("p",), 3)


def write(directory: Path, n: int, *, close: bool = True) -> SampleWriter:
    writer = SampleWriter(directory)
    writer.begin(HEADER)
    done = 0
    while done < n:
        rows = writer.rows(min(7, n - done))
        rows[:, 1:] = np.arange(done, done + len(rows))[:, None] + np.arange(6) / 10
        writer.commit(len(rows))
        done += len(rows)
    writer.pose(np.array([1.0, 2.0, 3.0]))
    if close:
        writer.close(np.array([4.0, 5.0, 6.0]))
    return writer


@pytest.mark.parametrize("n", [0, 1, 20, 16_384, 40_000])
def test_what_is_written_is_read(tmp_path: Path, n: int):
    write(tmp_path, n)
    samples = read_samples(tmp_path)
    assert samples.header == HEADER
    assert samples.n_steps == n
    assert samples.control.tolist() == [[i, i + 0.1] for i in range(n)]
    assert samples.pad_force[:, 0].tolist() == [i + 0.5 for i in range(n)]
    assert samples.poses.tolist() == [[1.0, 2.0, 3.0]]
    assert samples.end_pose is not None
    assert samples.end_pose.tolist() == [4.0, 5.0, 6.0]


def test_a_stretch_without_a_step_writes_nothing(tmp_path: Path):
    writer = write(tmp_path, 10, close=False)
    writer.rows(5)
    writer.commit(0)
    writer.close()
    assert read_samples(tmp_path).n_steps == 10


def test_rows_not_committed_are_not_read(tmp_path: Path):
    writer = write(tmp_path, 10, close=False)
    writer.rows(5)[:, 1:] = 1.0
    assert read_samples(tmp_path).n_steps == 10
    writer.close()


def test_samples_outlive_a_writer_that_is_killed(tmp_path: Path):
    program = (
        "import sys, numpy as np; from pathlib import Path\n"
        "from tracerisk.twin.recording.samples import SampleHeader, SampleWriter\n"
        "header = SampleHeader('arm', 'bench', 2000000, ('a', 'b'), ('j1',), ('p',), 3)\n"
        "writer = SampleWriter(Path(sys.argv[1])); writer.begin(header)\n"
        "for _ in range(2500):\n"
        "    writer.rows(8)[:, 1:] = 7.0; writer.commit(8)\n"
        "print('written', flush=True); sys.stdin.read()\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == b"written\n"
    os.kill(child.pid, signal.SIGKILL)
    child.communicate()
    samples = read_samples(tmp_path)
    assert samples.n_steps == 20_000
    assert (samples.torque == 7.0).all()
    assert samples.end_pose is None


def test_a_directory_without_samples_is_reported(tmp_path: Path):
    with pytest.raises(LogError, match=r"samples.json.*is no header of samples"):
        read_samples(tmp_path)


def test_rows_out_of_order_are_reported(tmp_path: Path):
    write(tmp_path, 10)
    flat = np.fromfile(tmp_path / "samples.bin").reshape(-1, HEADER.width)
    flat[3, 0] = 9.0
    flat.tofile(tmp_path / "samples.bin")
    with pytest.raises(LogError, match="missing or out of order"):
        read_samples(tmp_path)
