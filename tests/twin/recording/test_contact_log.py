"""The log of contacts: what the simulation writes, and what of it is read."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tracerisk.errors import LogError
from tracerisk.twin.recording.contact_log import (
    ROW,
    ContactLogWriter,
    LoggedBody,
    Weld,
    read_contacts,
)

ARM = LoggedBody("arm", "link")
TABLE = LoggedBody("table", "fixed")
BOX = LoggedBody("box", "free", 0.5)
NEW_BOX = LoggedBody("box", "free", 0.7)


def rows(*given: tuple[int, int, int, float]) -> np.ndarray:
    return np.array(list(given), dtype=ROW)


def test_what_is_written_is_read(tmp_path: Path):
    writer = ContactLogWriter(tmp_path)
    assert writer.model(0, (ARM, TABLE, BOX), {}).tolist() == [0, 1, 2]
    writer.append(rows((3, 0, 1, 2.5), (3, 0, 1, 1.5)))
    writer.append(rows((9, 0, 2, 4.0)))
    writer.close()
    writer.close()
    log = read_contacts(tmp_path, 10)
    assert log.bodies == (ARM, TABLE, BOX)
    assert log.rows.tolist() == [(3, 0, 1, 2.5), (3, 0, 1, 1.5), (9, 0, 2, 4.0)]
    assert read_contacts(tmp_path, 9).rows["step"].tolist() == [3, 3]


def test_a_changed_model_keeps_the_places_of_what_it_keeps(tmp_path: Path):
    writer = ContactLogWriter(tmp_path)
    writer.model(0, (ARM, TABLE, BOX), {})
    assert writer.model(40, (TABLE, NEW_BOX, ARM), {"box": "arm"}).tolist() == [1, 3, 0]
    writer.model(60, (ARM, TABLE, NEW_BOX), {})
    writer.model(80, (ARM, TABLE, NEW_BOX), {"box": "arm"})
    writer.close()
    log = read_contacts(tmp_path, 100)
    assert log.bodies == (ARM, TABLE, BOX, NEW_BOX)
    assert log.welds == (Weld(3, "arm", 40, 60), Weld(3, "arm", 80, 100))
    assert read_contacts(tmp_path, 50).welds == (Weld(3, "arm", 40, 50),)


def test_a_directory_without_a_log_has_no_contacts(tmp_path: Path):
    log = read_contacts(tmp_path, 10)
    assert (log.bodies, log.welds, len(log.rows)) == ((), (), 0)


def test_contacts_outlive_a_writer_that_is_killed(tmp_path: Path):
    program = (
        "import sys, numpy as np; from pathlib import Path\n"
        "from tracerisk.twin.recording.contact_log import ROW, ContactLogWriter, LoggedBody\n"
        "log = ContactLogWriter(Path(sys.argv[1]))\n"
        "log.model(0, (LoggedBody('arm', 'link'), LoggedBody('table', 'fixed')), {})\n"
        "log.append(np.array([(7, 0, 1, 120.0)], dtype=ROW))\n"
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
    assert read_contacts(tmp_path, 10).rows.tolist() == [(7, 0, 1, 120.0)]


def test_a_row_and_a_line_that_were_cut_short_are_left_out(tmp_path: Path):
    writer = ContactLogWriter(tmp_path)
    writer.model(0, (ARM, TABLE), {})
    writer.append(rows((1, 0, 1, 2.0), (2, 0, 1, 3.0)))
    writer.close()
    contacts, bodies = tmp_path / "contacts.bin", tmp_path / "contact_bodies.jsonl"
    contacts.write_bytes(contacts.read_bytes()[:-3])
    bodies.write_bytes(bodies.read_bytes() + b'{"step": 4, "bod')
    assert read_contacts(tmp_path, 10).rows["step"].tolist() == [1]


def test_contacts_of_unknown_bodies_are_reported(tmp_path: Path):
    writer = ContactLogWriter(tmp_path)
    writer.model(0, (ARM, TABLE), {})
    writer.append(rows((1, 0, 5, 2.0)))
    writer.close()
    with pytest.raises(LogError, match=r"contacts.bin.*bodies that contact_bodies.jsonl lacks"):
        read_contacts(tmp_path, 10)


def test_a_list_of_bodies_that_is_no_json_is_reported(tmp_path: Path):
    (tmp_path / "contact_bodies.jsonl").write_bytes(b"what\n")
    with pytest.raises(LogError, match=r"contact_bodies.jsonl.*is not a list of bodies"):
        read_contacts(tmp_path, 10)
