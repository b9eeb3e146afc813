"""The refresh that an editor asks for."""

import contextlib
import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from lsprotocol import types as lsp

from tests.editor.client import Editor

MOVES = [
    "arm.go([0.5, -0.5, 0, -2, 0, 1.5, 0.8])",
    "arm.go([-1.5, 0.5, 0, -2, 0, 1.5, 0.8])",
] * 300


def test_a_refresh_mends_what_is_stale(editor, cell):
    cell.write_text(cell.read_text().replace("joints[0] += 0.05", "joints[0] += 0.3"))
    before = cell.read_text()
    editor.open(cell)
    assert [each.code for each in editor.diagnostics(cell)] == ["stale"]
    assert (0, "refresh risk blocks") in editor.lenses(cell)
    assert editor.command("tracerisk.refresh", cell.as_uri()) is True
    assert editor.messages[-1].startswith("cell.py: risk blocks changed; ")
    assert cell.read_text() != before
    editor.change(cell, cell.read_text())
    assert editor.diagnostics(cell) == []
    assert (0, "refresh risk blocks") not in editor.lenses(cell)


def test_nothing_is_refreshed_over_what_is_not_saved(editor, cell):
    editor.open(cell)
    editor.change(cell, cell.read_text() + "\n# more\n")
    assert editor.command("tracerisk.refresh", cell.as_uri()) is False
    assert "cell.py is not saved" in editor.messages[-1]
    editor.close(cell)


def test_an_edit_stops_a_refresh_until_it_is_said_what_becomes_of_it(editor, cell):
    written = cell.read_text()
    edited = written.replace("quantity = 7", "quantity = 6", 1)
    cell.write_text(edited)
    editor.open(cell)
    assert editor.command("tracerisk.refresh", cell.as_uri()) is False
    assert "quantity" in editor.messages[-1]
    assert cell.read_text() == edited
    assert editor.command("tracerisk.refresh", cell.as_uri(), "discard-edits") is True
    assert cell.read_text() == written
    cell.write_text(edited)
    editor.change(cell, edited)
    assert editor.command("tracerisk.refresh", cell.as_uri(), "accept-edits") is True
    kept = cell.read_text()
    assert "quantity := 6" in kept
    assert "! computed 7" in kept
    editor.close(cell)


def test_what_is_no_policy_is_refused(editor, cell):
    assert editor.command("tracerisk.refresh", cell.as_uri(), "yes") is False
    assert "accept-edits, discard-edits" in editor.messages[-1]
    assert editor.command("tracerisk.refresh", "untitled:one") is False


# A controller ends with the process that runs it, as with a command that is killed (test_process).
@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks at processes by /proc")
def test_a_server_that_is_killed_leaves_no_process(cell):
    path = lengthened(cell)
    server = subprocess.Popen(
        [sys.executable, "-m", "tracerisk", "lsp"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )

    def send(**message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        server.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        server.stdin.flush()

    send(id=1, method="initialize", params={"capabilities": {}})
    send(method="initialized", params={})
    asked = {"command": "tracerisk.refresh", "arguments": [path.as_uri()]}
    send(id=2, method="workspace/executeCommand", params=asked)
    ends = time.monotonic() + 60
    while len(below := processes_below(server.pid)) < 3 and time.monotonic() < ends:
        time.sleep(0.05)
    assert len(below) >= 3
    server.kill()
    server.wait()
    ends = time.monotonic() + 15
    while any(map(is_running, below)) and time.monotonic() < ends:
        time.sleep(0.05)
    assert not any(map(is_running, below))


def lengthened(cell):
    """The controller with a run that takes minutes: a refresh runs it again."""
    text = cell.read_text()
    assert text.count("    pass\n") == 1
    cell.write_text(text.replace("    pass\n", "".join(f"    {each}\n" for each in MOVES)))
    return cell


def processes_below(top):
    parents = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError):
                stat = (folder / "stat").read_text()
                parents[int(folder.name)] = int(stat.rpartition(")")[2].split()[1])
    found, waiting = set(), [top]
    while waiting:
        new = [each for each, parent in parents.items() if parent == waiting[0]]
        found |= set(new)
        waiting = [*waiting[1:], *new]
    return found


def is_running(process):
    try:
        return "Z" not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False


def test_progress_is_shown_and_a_refresh_can_be_ended(tmp_path, cell):
    able = lsp.ClientCapabilities(window=lsp.WindowClientCapabilities(work_done_progress=True))
    editor = Editor(tmp_path, able)
    path = lengthened(cell)
    text = path.read_text()
    editor.open(path)
    began = threading.Event()

    def cancel() -> None:
        while not editor.progress_tokens:
            time.sleep(0.02)
        time.sleep(0.3)
        began.set()
        editor.client.window_work_done_progress_cancel(
            lsp.WorkDoneProgressCancelParams(editor.progress_tokens[-1])
        )

    threading.Thread(target=cancel).start()
    assert editor.command("tracerisk.refresh", path.as_uri()) is False
    assert began.is_set()
    assert "was ended" in editor.messages[-1]
    kinds = [each["kind"] if isinstance(each, dict) else each.kind for each in editor.progress]
    assert (kinds[0], kinds[-1]) == ("begin", "end")
    assert path.read_text() == text
    assert editor.end() == 0
