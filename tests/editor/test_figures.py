"""Hover, code lens and folding, asked by a real client of the server."""

import json

import pytest
from lsprotocol import types as lsp

from tests.editor.client import Editor
from tracerisk import build, solve


def line_of(text: str, begin: str) -> int:
    return next(n for n, line in enumerate(text.split("\n")) if line.lstrip().startswith(begin))


def test_a_function_shows_the_figures_of_the_solved_model(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    shown = editor.hover(cell, line_of(text, "def act"), 5)
    assessment = solve(build({str(cell): cell.read_bytes()}, name="x"))
    act = next(each for each in assessment.states if each.name == "act")
    whole = assessment.mission.geometric_cycles
    assert f"{act.absorption_probability:.3g} of {whole:.3g}" in shown
    assert f"{100 * act.absorption_probability / whole:.3g} %" in shown
    assert "visit" in shown
    assert "electric\\_motor | 7 of 7" in shown
    assert "panda\\_joint1: moving" in shown
    assert "not harm" in shown
    # The lock keeps no times of sensors: nothing is said of their use.
    (encoder,) = [line for line in shown.split("\n") if line.startswith("| encoder")] or [""]
    assert "not in use" not in shown, encoder


def test_a_call_of_a_function_shows_it_too(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    call = line_of(text, "home(arm)")
    assert editor.hover(cell, call, 5).startswith("**home**")
    assert editor.hover(cell, 0, 2) is None
    assert editor.hover(cell, 100_000, 3) is None


def test_a_component_of_a_block_shows_its_values_and_its_part(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    at = line_of(text, "# |   name = electric_motor")
    shown = editor.hover(cell, at, 9)
    assert shown.startswith("**electric\\_motor** in home")
    assert "- quantity: 7" in shown
    assert "of the failure probability of home" in shown
    assert "mission's failure probability would fall by" in shown


def test_a_value_set_by_hand_says_so_with_its_reason(editor, cell):
    text = cell.read_text()
    text = text.replace("quantity = 7", "quantity := 6 ! computed 7; one is locked", 1)
    editor.open(cell, text)
    at = line_of(text, "# |   quantity := 6")
    assert "quantity: 6, set by hand: one is locked; computed: 7" in editor.hover(cell, at, 9)


def test_lenses_stand_above_the_functions_and_the_mission(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    found = dict(editor.lenses(cell))
    assert "mission fails by its hardware with" in found[0]
    assert "partial" in found[0] or "complete" in found[0]
    assert "% of the mission's failure probability" in found[line_of(text, "def act")]
    assert "never ran" in found[line_of(text, "def never")]


def test_blocks_fold_as_a_whole_and_by_section(editor, cell):
    editor.open(cell)
    lines = cell.read_text().split("\n")
    found = editor.foldings(cell)
    wholes = [each for each in found if "RiskAnnotation" in lines[each[0]]]
    sections = [each for each in found if each not in wholes]
    assert len(wholes) == sum("RiskAnnotation" in line for line in lines)
    assert len(sections) == sum("# | @" in line for line in lines)
    assert all(lines[last].strip() == "# | }" for _, last in found)


def test_figures_follow_the_text_before_it_is_saved(editor, cell):
    editor.open(cell)
    text = cell.read_text()
    at = line_of(text, "def act")
    before = editor.hover(cell, at, 5)
    motors = text.index("name = electric_motor", text.index("name = act"))
    start = text.index("probability = ", motors)
    end = text.index("\n", start)
    editor.change(cell, text[:start] + "probability := 1e-3 ! computed 1e-9; x" + text[end:])
    after = editor.hover(cell, at, 5)
    assert before != after
    assert "| 0.001 |" in after


@pytest.mark.parametrize("break_it", ["def act(", "def act(arm)", "    (", "'''"])
def test_half_typed_code_keeps_what_is_known(editor, cell, break_it):
    editor.open(cell)
    text = cell.read_text()
    before = editor.hover(cell, line_of(text, "def home"), 5)
    broken = text.replace("    joints = arm", f"{break_it}\n    joints = arm", 1)
    assert broken != text
    editor.change(cell, broken)
    assert (
        editor.hover(cell, line_of(broken, "def home"), 5).split("\n")[0] == before.split("\n")[0]
    )
    assert editor.lenses(cell)
    assert [each.code for each in editor.diagnostics(cell)] == ["source"]
    assert editor.foldings(cell)


def test_a_malformed_block_leaves_the_others_readable(editor, cell):
    text = cell.read_text().replace("quantity = 7", "quantity = seven", 1)
    editor.open(cell, text)
    found = editor.diagnostics(cell)
    assert [each.code for each in found] == ["block"]
    assert found[0].range.start.line == line_of(text, "# |   quantity = seven")
    shown = editor.hover(cell, line_of(text, "def act"), 5)
    assert shown.startswith("**act**")
    assert "Not all of it could be read" in shown


def test_two_malformed_blocks_are_both_reported(editor, cell):
    text = cell.read_text().replace("quantity = 7", "quantity = seven")
    editor.open(cell, text)
    found = editor.diagnostics(cell)
    assert len(found) == text.count("quantity = seven") == 2


def test_columns_count_units_of_utf_16(editor, cell):
    text = cell.read_text()
    text = text.replace("    home(arm)", "    note = '\N{GRINNING FACE}äö'; home(arm)", 1)
    editor.open(cell, text)
    at = line_of(text, "note =")
    line = text.split("\n")[at]
    units = len(line[: line.index("home")].encode("utf-16-le")) // 2
    assert editor.hover(cell, at, units).startswith("**home**")
    assert editor.hover(cell, at, units + 4).startswith("**home**")
    assert editor.hover(cell, at, units - 2) is None


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("encoding", list(lsp.PositionEncodingKind))
def test_the_encoding_that_an_editor_asks_for_is_kept(tmp_path, cell, encoding):
    asked = lsp.ClientCapabilities(
        general=lsp.GeneralClientCapabilities(position_encodings=[encoding])
    )
    editor = Editor(tmp_path, asked)
    assert editor.started.capabilities.position_encoding == encoding
    text = cell.read_text()
    text = text.replace("    home(arm)", "    note = '\N{GRINNING FACE}äö'; home(arm)", 1)
    editor.open(cell, text)
    at = line_of(text, "note =")
    before = text.split("\n")[at].partition("home")[0]
    size = {"utf-8": 1, "utf-16": 2, "utf-32": 4}[encoding.value]
    codec = encoding.value if size == 1 else f"{encoding.value}-le"
    assert editor.hover(cell, at, len(before.encode(codec)) // size).startswith("**home**")
    assert editor.end() == 0


def test_lines_that_end_as_on_windows_are_read_alike(editor, cell):
    text = cell.read_text().replace("\n", "\r\n")
    cell.write_bytes(text.encode())
    editor.open(cell)
    assert editor.diagnostics(cell) == []
    at = line_of(text, "def act")
    assert editor.hover(cell, at, 5).startswith("**act**")
    lines = text.split("\r\n")
    assert all(lines[last].strip() == "# | }" for _, last in editor.foldings(cell))


def test_a_form_feed_ends_no_line(editor, cell):
    text = cell.read_text().replace("import os", "\f\nimport os\v", 1).replace("\v", "  # \v \x85")
    cell.write_bytes(text.encode())
    editor.open(cell)
    at = line_of(text, "def act")
    assert editor.hover(cell, at, 5).startswith("**act**")
    assert at in dict(editor.lenses(cell))


def test_a_text_that_is_no_source_has_nothing(editor, tmp_path):
    notes = tmp_path / "notes.txt"
    notes.write_text("def act\n")
    editor.open(notes, language="plaintext")
    assert editor.hover(notes, 0, 5) is None
    assert editor.lenses(notes) == []
    assert editor.foldings(notes) == []


def test_a_text_that_was_never_saved_shows_its_blocks(editor, cell, tmp_path):
    fresh = tmp_path / "fresh.py"
    text = cell.read_text()
    editor.open(fresh, text)
    assert editor.hover(fresh, line_of(text, "def act"), 5).startswith("**act**")
    assert [each.code for each in editor.diagnostics(fresh)] == ["unknown"]


def test_a_lock_of_another_shape_breaks_nothing(editor, cell):
    lock = cell.parent / "tracerisk.lock"
    data = json.loads(lock.read_text())
    data["controllers"]["cell.py"]["trace"] = {"functions": {"act": 7}, "verdict": 3}
    lock.write_text(json.dumps(data))
    editor.open(cell)
    assert editor.hover(cell, line_of(cell.read_text(), "def act"), 5).startswith("**act**")


def test_a_line_of_the_compact_form_shows_its_component_and_function(editor, cell, example_in):
    assert example_in(cell.parent).run("annotate", cell.name, "--form", "compact").code == 0
    editor.open(cell)
    text = cell.read_text()
    assert editor.diagnostics(cell) == []
    shown = editor.hover(cell, line_of(text, "# | electric_motor"), 9)
    assert shown.startswith("**electric\\_motor** in home")
    assert "- quantity: 7" in shown
    assert editor.hover(cell, line_of(text, "# | home 1"), 9).startswith("**home**")
