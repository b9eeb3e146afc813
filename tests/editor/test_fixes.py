"""Quick fixes: what is offered, and that each edit does what its title says."""

import pytest
from lsprotocol import types as lsp

from tests.editor.client import Editor


def offered(editor, path, line, *, only=None):
    where = lsp.Range(lsp.Position(line, 0), lsp.Position(line, 200))
    found = editor.ask(
        "text_document_code_action",
        lsp.CodeActionParams(
            lsp.TextDocumentIdentifier(path.as_uri()), where, lsp.CodeActionContext([], only)
        ),
    )
    return {each.title: each for each in found}


def applied(text, changes):
    """The text with the edits of one document, whose lines end with a line feed."""
    lines = text.split("\n")
    for each in sorted(changes, key=lambda one: one.range.start.line, reverse=True):
        start, end = each.range.start, each.range.end
        before, after = lines[start.line][: start.character], lines[end.line][end.character :]
        lines[start.line : end.line + 1] = (before + each.new_text + after).split("\n")
    return "\n".join(lines)


def line_of(text, begin, number=0):
    return [n for n, line in enumerate(text.split("\n")) if line.lstrip().startswith(begin)][number]


@pytest.fixture
def check(example_in, cell):
    def kinds():
        done = example_in(cell.parent).run("check", cell.name, "--json")
        return [each["kind"] for each in done.json["findings"]]

    return kinds


def test_a_stale_controller_is_offered_a_refresh(editor, cell):
    text = cell.read_text().replace("joints[0] += 0.05", "joints[0] += 0.06")
    editor.open(cell, text)
    assert [each.code for each in editor.diagnostics(cell)] == ["stale"]
    action = offered(editor, cell, 0)["Refresh the risk blocks of cell.py"]
    assert action.command.command == "tracerisk.refresh"
    assert list(action.command.arguments) == [cell.as_uri()]
    assert action.is_preferred
    assert [each.code for each in action.diagnostics] == ["stale"]
    assert "tracerisk.refresh" in editor.started.capabilities.execute_command_provider.commands


def test_what_needs_nothing_is_offered_nothing(editor, cell):
    editor.open(cell)
    assert editor.diagnostics(cell) == []
    assert offered(editor, cell, 0) == {}


def test_an_edit_can_be_kept_put_back_or_discarded(editor, cell, check):
    written = cell.read_text()
    text = written.replace("quantity = 7", "quantity = 6", 1)
    editor.open(cell, text)
    at = line_of(text, "# |   quantity = 6")
    assert [each.code for each in editor.diagnostics(cell)] == ["edited"]
    found = offered(editor, cell, at)
    assert set(found) == {
        "Put quantity back to 7",
        "Keep all edits of cell.py as set by hand, and refresh",
        "Discard all edits of cell.py, and refresh",
        "Set quantity by hand, with a reason",
    }
    changes = found["Put quantity back to 7"].edit.changes[cell.as_uri()]
    assert applied(text, changes) == written
    kept = found["Keep all edits of cell.py as set by hand, and refresh"].command
    assert list(kept.arguments) == [cell.as_uri(), "accept-edits"]
    gone = found["Discard all edits of cell.py, and refresh"].command
    assert list(gone.arguments) == [cell.as_uri(), "discard-edits"]
    changes = found["Set quantity by hand, with a reason"].edit.changes[cell.as_uri()]
    pinned = applied(text, changes)
    assert "quantity := 6 ! computed 7; " in pinned
    cell.write_text(pinned)
    assert check() == []


def test_a_value_is_set_by_hand_with_a_reason(editor, cell, check):
    text = cell.read_text()
    editor.open(cell)
    at = line_of(text, "# |   redundancy = true")
    assert list(offered(editor, cell, at)) == ["Set redundancy by hand, with a reason"]
    assert editor.command("tracerisk.pin", cell.as_uri(), at, "two lines! both fed") is True
    changes = editor.edits[-1].changes[cell.as_uri()]
    pinned = applied(text, changes)
    assert "redundancy := true ! computed true; two lines. both fed" in pinned
    cell.write_text(pinned)
    assert check() == []


def test_several_next_lines_are_one_value(editor, cell, check):
    text = cell.read_text()
    at = line_of(text, "# |   next = act 1")
    two = text.replace("# |   next = act 1", "# |   next = act 1/2\n    # |   next = done 1/2", 1)
    editor.open(cell, two)
    assert editor.command("tracerisk.pin", cell.as_uri(), at, "half are rejects") is True
    pinned = applied(two, editor.edits[-1].changes[cell.as_uri()])
    assert "next := act 1/2\n" in pinned
    assert "next := done 1/2 ! computed act 1; half are rejects\n" in pinned
    cell.write_text(pinned)
    assert check() == []


def test_a_value_without_a_reason_is_given_one(editor, cell, check):
    (cell.parent / "pyproject.toml").write_text("[tool.tracerisk]\nrequire_reason = true\n")
    text = cell.read_text().replace("quantity = 7", "quantity := 6 ! computed 7", 1)
    editor.open(cell, text)
    assert [each.code for each in editor.diagnostics(cell)] == ["unjustified"]
    at = line_of(text, "# |   quantity := 6")
    assert list(offered(editor, cell, at)) == ["Give a reason for quantity"]
    assert editor.command("tracerisk.pin", cell.as_uri(), at, "one is locked") is True
    pinned = applied(text, editor.edits[-1].changes[cell.as_uri()])
    assert "quantity := 6 ! computed 7; one is locked" in pinned
    cell.write_text(pinned)
    assert check() == []
    editor.change(cell, pinned)
    assert offered(editor, cell, at) == {}


def test_what_is_no_value_cannot_be_set(editor, cell):
    editor.open(cell)
    assert editor.command("tracerisk.pin", cell.as_uri(), 0, "why") is False
    assert "no value" in editor.messages[-1]
    assert editor.command("tracerisk.pin", cell.as_uri(), "three") is False
    assert editor.command("tracerisk.pin") is False


@pytest.fixture
def faulted(tmp_path, example_in, quick):
    example = example_in(tmp_path)
    path = example.write("bad.py", quick("rospy.logerr('the arm is cold')"))
    example.write("pyproject.toml", "[tool.tracerisk]\nseed = 0\n")
    assert example.run("run", "bad.py").code == 1
    return path


def test_a_reason_of_the_verdict_is_accepted_in_the_settings(editor, faulted, example_in):
    example = example_in(faulted.parent)
    settings = faulted.parent / "pyproject.toml"
    text = faulted.read_text()
    editor.open(faulted)
    assert [each.code for each in editor.diagnostics(faulted)] == ["faulted"]
    at = line_of(text, "rospy.logerr")
    action = offered(editor, faulted, at)["Accept error-logged in pyproject.toml"]
    changes = action.edit.changes[settings.as_uri()]
    empty = applied(settings.read_text(), changes)
    assert 'words = ""' in empty
    settings.write_text(empty)
    assert "words are missing" in example.run("check", "bad.py").out
    settings.write_text("[tool.tracerisk]\nseed = 0\n")
    (reason,) = example.run("check", "bad.py", "--json").json["verdicts"]
    reason = next(each for each in reason["verdict"]["reasons"] if each["code"] == "error-logged")
    given = [reason[key] for key in ("code", "function", "object")]
    assert editor.command("tracerisk.accept", faulted.as_uri(), *given, "a known sensor") is True
    settings.write_text(applied(settings.read_text(), editor.edits[-1].changes[settings.as_uri()]))
    done = example.run("refresh", "bad.py")
    assert done.code == 0, done.err
    editor.save(faulted)
    assert editor.diagnostics(faulted, seen=editor.reported(faulted)) == []


def test_settings_that_nothing_can_be_put_behind_are_left_alone(editor, faulted):
    settings = faulted.parent / "pyproject.toml"
    settings.write_text('[tool.tracerisk]\naccept = [{code = "never-ran", words = "x"}]\n')
    editor.open(faulted)
    editor.diagnostics(faulted)
    at = line_of(faulted.read_text(), "rospy.logerr")
    assert not [title for title in offered(editor, faulted, at) if title.startswith("Accept")]
    uri = faulted.as_uri()
    assert editor.command("tracerisk.accept", uri, "error-logged", "act", "", "why") is False
    assert editor.command("tracerisk.accept", uri, "deadlock", "act", "", "why") is False
    assert "never-ran" in editor.messages[-1]
    assert editor.command("tracerisk.accept", uri, "error-logged", "act", "", " ") is False


def test_an_editor_that_asks_for_reasons_gets_commands(tmp_path, faulted):
    editor = Editor(tmp_path, options={"asksForReasons": True})
    editor.open(faulted)
    editor.diagnostics(faulted)
    text = faulted.read_text()
    found = offered(editor, faulted, line_of(text, "rospy.logerr"))
    command = found["Accept error-logged in pyproject.toml, with a reason"].command
    assert command.command == "tracerisk.acceptWithReason"
    assert list(command.arguments[:3]) == [faulted.as_uri(), "error-logged", "act"]
    at = line_of(text, "# |   quantity = 7")
    command = offered(editor, faulted, at)["Set quantity by hand, with a reason"].command
    assert (command.command, list(command.arguments)) == (
        "tracerisk.pinWithReason",
        [faulted.as_uri(), at],
    )
    assert editor.end() == 0


def test_other_kinds_of_actions_have_none(editor, cell):
    text = cell.read_text()
    editor.open(cell)
    at = line_of(text, "# |   quantity = 7")
    assert offered(editor, cell, at, only=[lsp.CodeActionKind.SourceOrganizeImports]) == {}
    assert offered(editor, cell, at, only=[lsp.CodeActionKind.QuickFix])


@pytest.fixture
def compact(example_in, cell):
    outcome = example_in(cell.parent).run("annotate", cell.name, "--form", "compact")
    assert outcome.code == 0, outcome.err
    return cell


def test_an_edit_in_the_compact_form_can_be_put_back(editor, compact, check):
    written = compact.read_text()
    text = written.replace("  7\n", "  6\n", 1)
    assert text != written
    editor.open(compact, text)
    assert [each.code for each in editor.diagnostics(compact)] == ["edited"]
    at = line_of(text, "# | electric_motor")
    found = offered(editor, compact, at)
    changes = found["Put quantity back to 7"].edit.changes[compact.as_uri()]
    assert applied(text, changes) == written


def test_a_value_of_the_compact_form_is_set_by_hand(editor, compact, check):
    text = compact.read_text()
    editor.open(compact, text)
    at = line_of(text, "# | electric_motor")
    value = text.split("\n")[at].split()[3]
    found = offered(editor, compact, at)["Set probability by hand, with a reason"]
    pinned = applied(text, found.edit.changes[compact.as_uri()])
    assert f"# | electric_motor  := {value}  7        ! computed {value}" in pinned
    editor.change(compact, pinned)
    compact.write_text(pinned)
    assert check() == []
    next_line = line_of(text, "# | home 1")
    found = offered(editor, compact, next_line)["Set next by hand, with a reason"]
    changes = found.edit.changes[compact.as_uri()]
    assert "-> := " in applied(pinned, changes)


def test_a_long_reason_takes_lines_of_its_own_in_the_compact_form(editor, compact, check):
    text = compact.read_text()
    editor.open(compact, text)
    at = line_of(text, "# | electric_motor")
    reason = "the supplier derates the motors above forty degrees, as in this cell"
    assert editor.command("tracerisk.pin", compact.as_uri(), at, reason) is True
    pinned = applied(text, editor.edits[-1].changes[compact.as_uri()])
    assert max(map(len, pinned.split("\n"))) <= 79
    editor.change(compact, pinned)
    compact.write_text(pinned)
    assert check() == []
    assert offered(editor, compact, at) == {}
