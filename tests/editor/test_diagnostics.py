"""What the editor is told without asking is what `tracerisk check` gives."""

import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace

import pytest
from lsprotocol import types as lsp

from tests.editor.client import Editor
from tracerisk.adder.sources.insert import strip_blocks
from tracerisk.common.evidence.file import dump_evidence, read_evidence


def findings(example_in, cell):
    done = example_in(cell.parent).run("check", cell.name, "--json")
    return sorted((each["line"], text(each, cell)) for each in done.json["findings"])


def text(finding, cell) -> str:
    """What a finding says where the command is given from another folder, as the editor's is."""
    return f"{finding['message']}; {finding['remedy'].replace(f' {cell.name}', f' {cell}')}"


def shown(editor, cell):
    return sorted(
        (each.range.start.line + 1, each.message.partition(": ")[2])
        for each in editor.diagnostics(cell)
    )


def test_what_may_be_trusted_has_no_diagnostics(editor, cell):
    editor.open(cell)
    assert editor.diagnostics(cell) == []


@pytest.mark.parametrize(
    ("old", "new", "kinds"),
    [
        ("joints[0] += 0.05", "joints[0] += 0.06", {"stale"}),
        ("quantity = 7", "quantity = 6", {"edited"}),
        ("def home(", "def at_home(", {"stale", "orphaned"}),
        ("# scene", "# scene", set()),
    ],
)
def test_they_are_those_of_a_check(editor, cell, example_in, old, new, kinds):
    text = cell.read_text().replace(old, new)
    editor.open(cell, text)
    reported = shown(editor, cell)
    assert {each.code for each in editor.diagnostics(cell)} == kinds
    # The same by the command, once it is saved.
    cell.write_text(text)
    assert reported == findings(example_in, cell)
    editor.save(cell)
    assert shown(editor, cell) == reported


def test_a_limit_that_is_passed_is_an_error(editor, cell, example_in):
    (cell.parent / "pyproject.toml").write_text(
        "[tool.tracerisk]\nmax_failure_probability = 1e-15\n"
    )
    editor.open(cell)
    found = editor.diagnostics(cell)
    assert [each.code for each in found] == ["over_threshold"]
    assert found[0].severity == lsp.DiagnosticSeverity.Error
    assert shown(editor, cell) == findings(example_in, cell)


def test_a_faulted_run_is_an_error_at_its_line(editor, tmp_path, example_in, quick):
    example = example_in(tmp_path)
    path = example.write("bad.py", quick("rospy.logerr('the arm is cold')"))
    assert example.run("run", "bad.py").code == 1
    editor.open(path)
    found = editor.diagnostics(path)
    assert [each.code for each in found] == ["faulted"]
    assert "logerr" in path.read_text().split("\n")[found[0].range.start.line]
    assert shown(editor, path) == findings(example_in, path)


def test_an_unsaved_change_of_a_module_makes_its_controller_stale(
    editor, tmp_path, example_in, quick
):
    example = example_in(tmp_path)
    source = quick().replace("import os", "import moves, os", 1)
    source = source.replace("    act(arm)", "    moves.home(arm)\n    act(arm)")
    example.write("main.py", source)
    moves = example.write(
        "moves.py", 'def home(arm):\n    arm.set_named_target("ready")\n    arm.go()\n'
    )
    assert example.run("run", "main.py").code == 0
    main = tmp_path / "main.py"
    seen = editor.reported(main)
    editor.open(moves)
    assert editor.diagnostics(moves) == []
    assert "act" not in (editor.hover(moves, 0, 5) or "")
    assert editor.hover(moves, 0, 5).startswith("**home**")
    editor.change(moves, moves.read_text().replace('"ready"', '"extended"'))
    assert [each.code for each in editor.diagnostics(main, seen=seen)] == ["stale"]
    seen = editor.reported(main)
    editor.close(moves)
    assert editor.diagnostics(main, seen=seen) == []


def test_the_last_of_many_changes_is_what_counts(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    for number in range(40):
        editor.change(cell, text.replace("joints[0] += 0.05", f"joints[0] += 0.{number + 10}"))
    editor.change(cell, text)
    assert editor.diagnostics(cell) == []


def test_a_change_on_disk_that_the_editor_reports_is_looked_at(editor, cell):
    editor.open(cell)
    assert editor.diagnostics(cell) == []
    lock = cell.parent / "tracerisk.lock"
    kept = lock.read_bytes()
    lock.unlink()
    seen = editor.reported(cell)
    event = lsp.FileEvent(lock.as_uri(), lsp.FileChangeType.Deleted)
    editor.client.workspace_did_change_watched_files(lsp.DidChangeWatchedFilesParams([event]))
    assert [each.code for each in editor.diagnostics(cell, seen=seen)] == ["unknown"]
    lock.write_bytes(kept)
    seen = editor.reported(cell)
    editor.client.workspace_did_change_watched_files(lsp.DidChangeWatchedFilesParams([event]))
    assert editor.diagnostics(cell, seen=seen) == []


def test_an_unreadable_lock_is_reported_at_the_lock(editor, cell):
    lock = cell.parent / "tracerisk.lock"
    lock.write_text("{")
    seen = editor.reported(lock)
    editor.open(cell)
    found = editor.diagnostics(lock, seen=seen)
    assert [each.code for each in found] == ["lock"]


def test_a_deleted_controller_is_reported_of(editor, cell):
    editor.open(cell)
    assert editor.diagnostics(cell) == []
    cell.unlink()
    seen = editor.reported(cell)
    editor.save(cell)
    assert [each.code for each in editor.diagnostics(cell, seen=seen)] == ["gone"]


def test_a_program_that_is_no_controller_has_none(editor, tmp_path):
    path = tmp_path / "tool.py"
    path.write_text("print('x'\n")
    editor.open(path)
    assert editor.diagnostics(path) == []


def test_a_file_in_another_encoding_is_fresh_as_it_is(editor, tmp_path, example_in, quick):
    example = example_in(tmp_path)
    source = "# -*- coding: latin-1 -*-\n# käse\n" + quick("home(arm)")
    path = example.write("old.py", source.encode("latin-1"))
    assert example.run("run", "old.py").code == 0
    editor.open(path, path.read_bytes().decode("latin-1"))
    assert editor.diagnostics(path) == []


def test_a_byte_order_mark_that_editors_hide_is_no_change(editor, tmp_path, example_in, quick):
    example = example_in(tmp_path)
    path = example.write("old.py", b"\xef\xbb\xbf" + quick().encode())
    assert example.run("run", "old.py").code == 0
    assert path.read_bytes().startswith(b"\xef\xbb\xbf")
    editor.open(path, path.read_text("utf-8-sig"))
    assert shown(editor, path) == []


def test_blocks_of_cpp_have_diagnostics_too(editor, tmp_path, example_in):
    pytest.importorskip("tree_sitter_cpp")
    path = tmp_path / "arm.cpp"
    path.write_text(
        "void pick() {\n  /***\n   * RiskAnnotation\n   * @Function {\n   *   name = pick\n"
        "   *   callSequence = 1\n   * }\n   * @Component {\n   *   name = motor\n"
        "   *   probability = 1e-6\n   *   quantity = 1\n   *   redundancy = false\n   * }\n   ***/\n"
        "  go();\n}\n"
    )
    editor.open(path, language="cpp")
    assert [line for line, _ in shown(editor, path)] == [
        line for line, _ in findings(example_in, path)
    ]
    assert editor.hover(path, 0, 6).startswith("**pick**")
    assert editor.foldings(path) == [(1, 13), (3, 6), (7, 12)]
    editor.change(path, path.read_text().replace("1e-6", "often"))
    assert [each.code for each in editor.diagnostics(path)] == ["block"]


def test_an_editor_that_watches_files_is_asked_to(tmp_path):
    able = lsp.ClientCapabilities(
        workspace=lsp.WorkspaceClientCapabilities(
            did_change_watched_files=lsp.DidChangeWatchedFilesClientCapabilities(
                dynamic_registration=True
            ),
            code_lens=lsp.CodeLensWorkspaceClientCapabilities(refresh_support=True),
        )
    )
    editor = Editor(tmp_path, able)
    path = tmp_path / "a.py"
    path.write_text("def a():\n    pass\n")
    editor.open(path)
    assert editor.diagnostics(path) == []
    assert [each.method for each in editor.registered] == ["workspace/didChangeWatchedFiles"]
    assert editor.end() == 0


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_the_server_ends_by_a_signal(number):
    process = subprocess.Popen(
        [sys.executable, "-m", "tracerisk", "lsp"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    body = b'{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}'
    process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
    process.stdin.flush()
    assert process.stdout.readline().startswith(b"Content-Length")
    os.kill(process.pid, number)
    assert process.wait(20) == 128 + number


def test_the_server_ends_with_its_editor():
    process = subprocess.run(
        [sys.executable, "-m", "tracerisk", "lsp"], input=b"", capture_output=True, timeout=30
    )
    assert process.returncode == 0
    assert process.stdout == b""


def test_the_folder_that_goes_takes_the_server_with_nothing(editor, cell):
    editor.open(cell)
    assert editor.diagnostics(cell) == []
    shutil.rmtree(cell.parent)
    seen = editor.reported(cell)
    editor.save(cell)
    assert editor.diagnostics(cell, seen=seen) is not None
    assert editor.hover(cell, 0, 0) is None


def test_where_a_check_would_help_is_shown_as_information(editor, cell, example_in):
    example = example_in(cell.parent)
    done = example.run("evidence", cell.name, "--cells", "1", "--shard", "1/8", "-j", "1", "-q")
    assert done.code == 0, done.err
    path = cell.parent / "tracerisk.evidence"
    found = read_evidence(path)[cell.name]
    line = cell.read_text().splitlines().index("    arm.go()") + 1
    bare = (
        strip_blocks(cell.read_bytes(), cell.name).decode().splitlines().index("    arm.go()") + 1
    )
    undetected = {"fails": True, "fate": "unaware", "missed_check": "result"}
    cells = [replace(each, **undetected, missed_at=f"{cell.name}:{bare}") for each in found.cells]
    path.write_text(dump_evidence({cell.name: replace(found, cells=tuple(cells))}))
    editor.open(cell)
    (shown,) = editor.diagnostics(cell)
    assert (shown.severity, shown.code) == (lsp.DiagnosticSeverity.Information, "undetected")
    assert shown.range.start.line + 1 == line
    assert shown.message.startswith(
        f"the answer to this call is not looked at: {len(cells)} failures end the mission undetect"
    )
    # The lines of another version are not those of the evidence.
    seen = editor.reported(cell)
    editor.change(cell, cell.read_text().replace("joints[0] += 0.05", "joints[0] += 0.06"))
    assert {each.code for each in editor.diagnostics(cell, seen=seen)} == {"stale"}
