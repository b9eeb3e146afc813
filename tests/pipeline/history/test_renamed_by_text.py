"""Names that search and replace changed in code and blocks alike, and files renamed with them."""

import re
from pathlib import Path

import pytest

from tests.pipeline.history.renaming_histories import CppHistory, RenamingHistory
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.cli import main
from tracerisk.errors import EditInTheWayError
from tracerisk.pipeline.check.check import check_controller
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.project import Projects

HARDWARE = """\
components:
  motor: {probability: {value: 9.5e-08, per: visit}, quantity: 7, twin: {joints: '*'}}
  gripper: {probability: {value: 7.344e-08, per: visit}, twin: {joints: '*'}}
"""
ACTIVE = {"home": "motor", "place": "motor,gripper", "leave": "gripper"}
PYTHON = "".join(f"def {name}(arm):\n    arm.go()\n\n\n" for name in ACTIVE)
CPP = "".join(f"void {name}() {{\n  go();\n}}\n\n" for name in ACTIVE)
CLASSES = "class Cell:\n" + "".join(
    f"    def {name}(self):\n        self.go()\n\n" for name in ACTIVE
)


class Cell:
    """A controller whose run is a log."""

    def __init__(self, file: str, source: str) -> None:
        self.file = file
        self.scope = "Cell." if "class Cell" in source else ""
        Path("pyproject.toml").write_text("")
        Path("arm.yaml").write_text(HARDWARE)
        self.write(source)
        assert self.annotate("home place home leave") == 0

    def read(self) -> str:
        return Path(self.file).read_text()

    def write(self, text: str) -> None:
        Path(self.file).write_text(text)

    def replace(self, old: str, new: str) -> None:
        """Search and replace a word, in code and comments."""
        self.write(re.sub(rf"\b{old}\b", new, self.read()))

    def annotate(self, calls: str, *options: str, active: dict[str, str] = ACTIVE) -> int:
        """Write the blocks of a run that calls the functions in this order."""
        parts = [
            f"Function:{self.scope}{name}()\nActiveComponents:{active[name]}"
            for name in dict.fromkeys(calls.split())
        ]
        sequence = ",".join(f"{self.scope}{name}()" for name in calls.split())
        Path("run.log").write_text("\n".join([*parts, "", f"CallSequence:{sequence}"]))
        options = ("--log", "run.log", "--hardware", "arm.yaml", "--quiet", *options)
        return main(["annotate", self.file, *options])

    def findings(self) -> list[str]:
        found = check_controller(Path(self.file), Projects()).findings
        return [f"{each.kind} {each.message}" for each in found]


@pytest.fixture(
    params=[("c.py", PYTHON), ("c.py", CLASSES), ("c.cpp", CPP)], ids=["python", "class", "cpp"]
)
def cell(request, tmp_path, monkeypatch) -> Cell:
    monkeypatch.chdir(tmp_path)
    return Cell(*request.param)


def renamed(**names: str) -> dict[str, str]:
    return {names.get(name, name): components for name, components in ACTIVE.items()}


def test_another_order_and_a_name_replaced_everywhere_are_no_edit(cell, capsys):
    cell.replace("home", "rest")
    assert not [text for text in cell.findings() if text.startswith(("edited", "undecided"))]
    active = renamed(home="rest")
    code = cell.annotate("place rest place rest leave", active=active)
    assert code == 0, capsys.readouterr().err
    assert ":=" not in cell.read()
    assert f"next = {cell.scope}rest 1\n" in cell.read()
    assert cell.findings() == []


def test_accepting_edits_pins_the_edit_and_not_what_a_renaming_left(cell):
    text = cell.read()
    figure = re.search(r"probability = (\S+)", text)[1]
    cell.write(text.replace(f"probability = {figure}", "probability = 2e-07", 1))
    cell.replace("home", "rest")
    active = renamed(home="rest")
    assert cell.annotate("place rest place rest leave", active=active) == 3
    assert cell.annotate("place rest place rest leave", "--accept-edits", active=active) in (0, 3)
    assert not re.search(r"next :=|callSequence :=", cell.read())
    assert "2e-07" in cell.read()


def test_an_edited_next_is_still_an_edit_where_another_function_was_renamed(cell, capsys):
    cell.replace("home", "rest")
    was = re.search(r"next = (\S*)leave 1/2\n", cell.read())
    cell.write(cell.read().replace(was[0], f"next = {was[1]}leave 1/4\n"))
    cell.write(cell.read().replace("place 1/2\n", "place 3/4\n"))
    assert cell.annotate("rest place rest leave", active=renamed(home="rest")) == 3
    assert "rest.next" in capsys.readouterr().err


def test_two_names_that_changed_places_are_followed(cell):
    """All three are renamed, and one has the name that another had."""
    cell.replace("home", "tmp")
    cell.replace("place", "rest")
    cell.replace("tmp", "put")
    assert cell.annotate("rest put leave", active=renamed(home="put", place="rest")) == 0
    assert ":=" not in cell.read()
    assert cell.findings() == []


def test_function_and_file_are_renamed_together(cell, capsys):
    text = cell.read()
    figure = re.search(r"probability = (\S+)", text)[1]
    pinned = f"probability := 2e-07  ! computed {figure}; FMEA-112"
    cell.write(text.replace(f"probability = {figure}", pinned, 1))
    assert cell.annotate("home place home leave") == 0
    # In the code alone: the blocks have the old names.
    code = re.sub(r"^( *(?:def|void) )home\b", r"\1rest", cell.read(), flags=re.MULTILINE)
    was, new = cell.file, f"cell{Path(cell.file).suffix}"
    Path(was).rename(new)
    cell.file = new
    cell.write(code)
    kinds = {text.split()[0] for text in cell.findings()}
    assert kinds & {"gone", "orphaned"}
    assert cell.annotate("rest place rest leave", active=renamed(home="rest")) == 0
    assert pinned in cell.read()
    assert cell.findings() == []
    # The lock has one entry, under the new name.
    assert list(load_controller(Path(new)).project.lock.controllers) == [new]
    assert main(["check"]) == 0


@pytest.fixture(params=["python", "cpp"])
def history(request, tmp_path) -> RenamingHistory:
    kind = RenamingHistory if request.param == "python" else CppHistory
    return kind(tmp_path / "r", seed=1)


def moved(history: RenamingHistory, name: str, new_name: str) -> str:
    """Move a function to a file of its own, and replace its name in all files."""
    part = next(part for part in history.parts() if part.name == name)
    lines = history.lines_of(part)
    history.put(part, [])
    file = f"arm{Path(part.file).suffix}"
    (history.folder / file).write_text("".join(lines))
    for each in history.files():
        history.write(each, re.sub(rf"\b{name}\b", new_name, history.read(each)))
    return file


def test_a_function_that_moved_under_another_name_leaves_no_edit(history):
    file = moved(history, "home", "rest")
    history.call(["leave", *history.calls()])
    assert history.annotated(MergePolicy("accept")).is_changed
    history.refresh()
    assert ":=" not in history.text()
    assert history.stops == 0
    assert "name = rest" in history.read(file)


def test_a_pinned_value_of_a_function_that_moved_and_is_called_no_more_stays(history):
    part = next(part for part in history.parts() if part.name == "home")
    lines = history.lines_of(part)
    at = next(number for number, line in enumerate(lines) if "probability = " in line)
    lines[at] = re.sub(r"= .*", ":= 2e-07  ! FMEA-112", lines[at])
    history.typed.pins.add("2e-07")
    history.put(part, lines)
    history.refresh()
    file = moved(history, "home", "rest")
    history.call([name for name in history.calls() if name != "rest"])
    history.refresh()
    assert "probability := 2e-07  ! computed none; FMEA-112\n" in history.read(file)
    # The lock knows the file from now on.
    entry = load_controller(history.folder / history.script).project.lock.controllers
    assert set(entry[history.script].blocks) == {history.script, file}


def test_a_file_whose_functions_all_moved_away_is_not_missed(history):
    part = next(part for part in history.parts() if part.name == "home")
    lines = history.lines_of(part)
    history.put(part, [])
    module = f"arm{Path(part.file).suffix}"
    (history.folder / module).write_text("".join(lines))
    history.refresh()
    (history.folder / module).unlink()
    script = history.folder / history.script
    script.write_text(script.read_text() + "\n\n" + re.sub(r"\bhome\b", "rest", "".join(lines)))
    history.write(history.script, re.sub(r"\bhome\b", "rest", history.read(history.script)))
    found = check_controller(script, Projects()).findings
    assert [finding for finding in found if finding.kind == "missing"] == []


def test_a_copy_of_a_function_in_another_file_is_none_that_moved(history):
    """Its block is of nobody whose functions are all where they were."""
    part = next(part for part in history.parts() if part.name == "leave")
    copy = "".join(history.lines_of(part)).replace("leave", "rest")
    file = f"arm{Path(part.file).suffix}"
    history.write(file, copy)
    history.refresh()
    assert history.read(file) == copy


def test_where_another_branch_may_have_renamed_what_follows_nobody_is_named(history):
    """The lock and the digests are lost: git alone knows the earlier names."""
    history.commit()
    text = re.sub(r"(RiskAnnotation) \S+", r"\1", history.read())
    history.write(history.script, re.sub(r"\bhome\b", "rest", text))
    (history.folder / "tracerisk.lock").unlink()
    place = history.calls()[1]
    history.call(["rest", place, "leave"])
    with pytest.raises(EditInTheWayError) as caught:
        history.annotated(MergePolicy("accept"))
    doubtful = str(caught.value).partition("it is unknown who wrote these values")[2]
    assert ".next is rest 1" in doubtful
