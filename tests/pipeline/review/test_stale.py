"""A version that nobody has run: its figure is that of another, and no limit holds for it."""

from dataclasses import replace
from itertools import product

import pytest

from tests.pipeline.review.test_review import lock_of, only, write
from tests.slow import slow_but_every
from tracerisk.adder.lock.lock import Lock
from tracerisk.common.text.digests import sha256
from tracerisk.common.text.plain_data import plain_data
from tracerisk.common.verdict import Coverage, Reason, Verdict
from tracerisk.config import Settings
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.freshness.run_inputs import hardware_digest
from tracerisk.pipeline.review.review import review
from tracerisk.pipeline.trace.kept_verdict import with_refused
from tracerisk.pipeline.workspace.project import Project

SETTINGS = '[tool.tracerisk]\nhardware = "hw.yaml"\n'
HARDWARE = "components:\n  motor: {failure_rate: {value: RATE, per: hour}, source: SOURCE}\n"
COMPLETE = plain_data(Verdict("complete", (), Coverage(1, 1)))
LIMITS = (
    ("--max-increase", "0.1"),
    ("--max-failure-probability", "0.5"),
    ("--no-outcome-change",),
)


def hardware(rate="1e-7", source="IEC 61709"):
    return HARDWARE.replace("RATE", rate).replace("SOURCE", source)


@pytest.fixture
def cell(repository, annotated_source):
    """A controller whose run depended on settings, a hardware description and a scene."""
    source = annotated_source(pick=("place 1", "motor = 1e-7"), place=("done 1", "gripper = 2e-07"))
    files = {"pick.py": source, "helper.py": "REACH = 0.2\n"}
    entry = lock_of(
        {"pick.py": source},
        "pick.py",
        sources={name: code_digest(text.encode(), name) for name, text in files.items()},
        files={"scene.xml": sha256(b"<mujoco/>")},
        settings={"hardware": "hw.yaml", "tracerisk": "0.1"},
        hardware=sha256(hardware().encode()),
    )
    entry = replace(entry, trace={"verdict": COMPLETE})
    more = {"pyproject.toml": SETTINGS, "hw.yaml": hardware(), "scene.xml": "<mujoco/>"}
    write(repository, {**files, **more}, ("pick.py", entry))
    repository.commit()
    return repository


CHANGES = (
    ("hw.yaml", hardware("3e-7"), "hw.yaml has changed"),
    ("helper.py", "REACH = 0.5\n", "helper.py has changed"),
    ("scene.xml", "<mujoco><worldbody/></mujoco>", "scene.xml has changed"),
    ("pyproject.toml", f"{SETTINGS}seed = 4\n", "setting seed was the default, is 4"),
    ("pyproject.toml", "[tool.tracerisk]\n", "setting hardware was hw.yaml, is the default"),
)
VERSIONS = (["HEAD"], ["HEAD~1..HEAD"], ["HEAD", "pick.py"])


# Every fourth has each change, and each limit with each way to name versions.
@pytest.mark.slow(but=4)
@pytest.mark.parametrize(
    ("versions", "limit", "change"), slow_but_every(4, [*product(VERSIONS, LIMITS, CHANGES)])
)
def test_a_change_that_nobody_has_run_is_said_and_passes_no_limit(cell, versions, limit, change):
    file, text, said = change
    cell.write(file, text)
    if versions == ["HEAD~1..HEAD"]:
        cell.commit()
    found = only(review(versions, cell.folder))
    assert found.stale == (said,)
    done = cell.run("diff", *versions)
    assert done.code == 0
    assert f"pick.py is not assessed as it is now: since its last run {said}" in " ".join(
        done.out.split()
    )
    assert "falls" not in done.out
    done = cell.run("diff", *versions, *limit)
    assert done.code == 1
    assert f"{said}; {' '.join(limit)}" in done.err


FIGURE = "@TraceriskHardware::FailureData {{ rate = {} [SI::h^-1]; }}"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["parts.sysml", "Parts.SYSML"])
def test_a_file_of_a_described_folder_that_changes_makes_the_figure_stale(cell, name):
    """The description is a folder of SysML, of which one part is the system."""
    parts = "package P {{ part def M {{ " + FIGURE + " }} }}"
    cell.write(f"model/a/{name}", parts.format("1e-7"))
    cell.write(
        "model/cell.sysml",
        "package C { private import P::*; part cell { part motor : M; } part other { part m : M; } }",
    )
    settings = '[tool.tracerisk]\nhardware = "model"\nsystem = "cell"\n'
    cell.write("pyproject.toml", settings)
    now = hardware_digest(Settings(hardware=str(cell.folder / "model")))
    lock = (cell.folder / "tracerisk.lock").read_text()
    lock = lock.replace(sha256(hardware().encode()), now)
    lock = lock.replace('"hardware": "hw.yaml"', '"hardware": "model", "system": "cell"')
    cell.write("tracerisk.lock", lock)
    cell.commit()
    assert review([], cell.folder).controllers == ()
    cell.write(f"model/a/{name}", parts.format("3e-7"))
    found = only(review([], cell.folder))
    assert found.stale == ("model has changed",)
    (said,) = found.hardware
    assert said.startswith("motor (model/cell.sysml:1")
    assert "1e-07/h" in said
    assert "3e-07/h" in said
    cell.write("pyproject.toml", settings.replace("cell", "other"))
    assert "setting system was cell, is other" in only(review([], cell.folder)).stale


def test_a_file_beside_a_description_counts_in_whatever_case_its_name_is(cell):
    cell.write("Motors.SYSML", "package M { part def Motor { " + FIGURE.format("1e-7") + " } }")
    cell.write("Arm.SYSML", "package A { private import M::*; part arm { part motor : Motor; } }")
    cell.write("pyproject.toml", SETTINGS.replace("hw.yaml", "Arm.SYSML"))
    lock = (cell.folder / "tracerisk.lock").read_text().replace("hw.yaml", "Arm.SYSML")
    now = hardware_digest(Settings(hardware=str(cell.folder / "Arm.SYSML")))
    cell.write("tracerisk.lock", lock.replace(sha256(hardware().encode()), now))
    cell.commit()
    cell.write("Arm.SYSML", "package A { part arm { part motor : M::Motor; } }")
    cell.write("Motors.SYSML", "package M { part def Motor { " + FIGURE.format("3e-7") + " } }")
    found = only(review([], cell.folder))
    assert found.stale == ("Arm.SYSML has changed",)
    assert "3e-07/h" in found.hardware[0]
    cell.git("checkout", "Arm.SYSML")
    assert only(review([], cell.folder)).stale == ("Arm.SYSML has changed",)
    cell.git("checkout", "Motors.SYSML")
    assert review([], cell.folder).controllers == ()


def test_what_changes_no_run_is_no_change(cell):
    cell.write("README.md", "A cell\n")
    cell.write("pyproject.toml", f"# a comment\n{SETTINGS}max_failure_probability = 0.1\n")
    cell.write("helper.py", "# said better\nREACH = 0.2\n")
    assert review([], cell.folder).controllers == ()


def test_a_file_that_is_gone_is_said(cell):
    (cell.folder / "scene.xml").unlink()
    assert only(review([], cell.folder)).stale == ("scene.xml is gone",)


def test_a_changed_input_is_looked_at_from_a_subfolder_and_by_the_name_that_is_typed_there(cell):
    cell.write("sub/x.txt", "")
    cell.write("hw.yaml", hardware("3e-7"))
    assert only(review([], cell.folder / "sub")).stale == ("../hw.yaml has changed",)


@pytest.mark.parametrize("lost", ["pick", "place"])
def test_a_function_that_is_gone_makes_nothing_look_safer(cell, lost):
    text = (cell.folder / "pick.py").read_text()
    at = text.index(f"def {lost}(")
    after = text.find("\ndef ", at)
    cell.write("pick.py", text[:at] + ("" if after < 0 else text[after + 1 :]))
    found = only(review([], cell.folder))
    assert found.stale == ("pick.py has changed",)
    assert found.is_unchanged
    assert cell.run("diff", "--max-increase", "0.1").code == 1


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("also", ["", "name = ", "next = "])
def test_a_function_that_was_renamed_keeps_its_figure(cell, also):
    text = (cell.folder / "pick.py").read_text().replace("def place(", "def put(")
    if also:
        text = text.replace("name = place", "name = put")
    if also == "next = ":
        text = text.replace("next = place", "next = put")
    cell.write("pick.py", text)
    found = only(review([], cell.folder))
    assert found.stale == ("pick.py has changed",)
    assert found.is_unchanged
    assert [(one.name, one.was) for one in found.functions] == [("pick", None), ("put", "place")]


def test_a_copy_that_no_run_wrote_is_no_assessment(cell):
    copy = (cell.folder / "pick.py").read_text()
    cell.write("copy.py", copy)
    cell.commit()
    found = only(review(["HEAD~1..HEAD"], cell.folder))
    assert found.stale == ("tracerisk.lock knows no run of it",)
    done = cell.run("diff", "HEAD~1..HEAD", "--max-failure-probability", "0.5")
    assert done.code == 1
    assert "assessed for the first time" not in done.out


CLASS = """\
class Cell:
    def go(self, arm):
        BLOCK
        arm.go("part")

    def never(self, arm):
        self.helper(arm)

    def helper(self, arm):
        arm.go("tray")


def apart(arm):
    arm.go("box")
"""


@pytest.mark.parametrize(
    "names", [[("Cell", "Zelle")], [("apart", "aside")], [("Cell", "Zelle"), ("apart", "aside")]]
)
def test_what_never_ran_is_no_news_under_another_name(repository, annotated_source, names):
    block = annotated_source(go=("done 1", "motor = 1e-7")).split("\n")
    lines = [line.strip() for line in block if line.strip().startswith("#")]
    text = CLASS.replace("BLOCK", "\n        ".join(lines)).replace("name = go", "name = Cell.go")
    never = ["Cell.helper", "Cell.never", "apart"]
    for version in (0, 1):
        if version:
            for old, new in names:
                text = text.replace(old, new)
                never = [name.replace(old, new) for name in never]
        entry = lock_of({"pick.py": text}, "pick.py")
        trace = {"verdict": COMPLETE, "uncovered": {"pick.py": never}}
        entry = replace(entry, trace=trace)
        write(repository, {"pick.py": text}, ("pick.py", entry))
        if not version:
            repository.commit()
    found = only(review([], repository.folder))
    assert found.of_comparison == (
        "what the earlier run brought about is not known: its lock does not say",
        "what the later run brought about is not known: its lock does not say",
    )


def test_check_finds_blocks_that_no_run_wrote(cell):
    assert cell.run("check").code == 1  # the settings say more than this run had
    copy = (cell.folder / "pick.py").read_text()
    cell.write("more/copy.py", copy)
    cell.write("more/own/package.xml", "<package/>")
    cell.write("more/own/by_hand.py", copy)
    cell.write(
        "more/own/by_tool.py", copy.replace("RiskAnnotation", "RiskAnnotation BmIYUI-ZtZrQ2")
    )
    cell.write("more/text.py", f'TEXT = """\n{copy}"""\n')
    found = cell.run("check")
    assert found.code == 1
    unknown = [line.partition(":")[0] for line in found.out.splitlines() if ": unknown: " in line]
    assert unknown == ["more/copy.py", "more/own/by_tool.py"]
    assert "more/copy.py:1: unknown: tracerisk.lock knows nothing of its 2 risk blocks" in found.out


def test_a_changed_description_is_said_with_old_and_new_figures_and_sources(cell):
    cell.write("hw.yaml", hardware("3e-7", "data sheet"))
    said = "motor (hw.yaml:2): failure_rate 1e-07/h (IEC 61709) -> 3e-07/h (data sheet)"
    assert only(review([], cell.folder)).hardware == (said,)
    assert said in " ".join(cell.run("diff").out.split())
    lock = (cell.folder / "tracerisk.lock").read_text()
    old, new = (sha256(hardware(*given).encode()) for given in ((), ("3e-7", "data sheet")))
    cell.write("tracerisk.lock", lock.replace(old, new))
    source = (cell.folder / "pick.py").read_text()
    cell.write("pick.py", source.replace("1e-7", "3e-7"))
    refreshed = only(review([], cell.folder))
    assert (refreshed.hardware, refreshed.stale) == ((said,), ())
    # A reviewer is led to the line of the description.
    before = cell.git("rev-parse", "HEAD").strip()
    commit = cell.commit()
    base = ("--format", "markdown", "--link-base", "https://git.example/cell/blob")
    markdown = cell.run("diff", *base, f"{before}..HEAD").out
    assert f"[hw.yaml:2](https://git.example/cell/blob/{commit}/hw.yaml#L2)" in markdown


def test_other_line_ends_of_a_text_make_no_version_stale(cell):
    plain = "<mujoco>\n</mujoco>\n"
    lock = cell.read("tracerisk.lock").decode()
    cell.write("tracerisk.lock", lock.replace(sha256(b"<mujoco/>"), sha256(plain.encode())))
    cell.write("scene.xml", plain)
    cell.commit()
    cell.write("scene.xml", plain.replace("\n", "\r\n"))
    cell.commit()
    outcome = cell.run("diff", "HEAD~1..HEAD", "--max-failure-probability", "0.5")
    assert outcome.code == 0, outcome.err


def test_a_figure_of_blocks_that_are_stale_is_not_shown_as_that_of_the_later_version(cell):
    cell.write("helper.py", "REACH = 0.5\n")
    outcome = cell.run("diff", "HEAD")
    assert outcome.code == 0
    assert outcome.out.startswith("complete, 1 of 1 function with commands ran (of its last run: ")
    (row,) = (line for line in outcome.out.splitlines() if line.startswith("  mission failure"))
    assert row.split()[-3:] == ["-", "not", "assessed"]
    assert outcome.err.startswith("exit code 0, though pick.py did not pass: --max-increase R ")
    markdown = cell.run("diff", "HEAD", "--format", "markdown").out
    (row,) = (line for line in markdown.splitlines() if line.startswith("|") and "pick.py" in line)
    assert row.split(" | ")[2] == "none"
    assert cell.run("diff", "HEAD", "--max-increase", "0.1").code == 1


def test_a_run_that_was_refused_is_named_and_not_promised_to_refresh(cell):
    faulted = Verdict(
        "faulted", (Reason("object-dropped", "faulted", "'jar' fell"),), Coverage(1, 1)
    )
    cell.write("helper.py", "REACH = 0.5\n")
    (entry,) = Project(cell.folder).lock.controllers.values()
    sources = {**entry.inputs["sources"], "helper.py": code_digest(b"REACH = 0.5\n", "helper.py")}
    refused = with_refused(entry, faulted, {**entry.inputs, "sources": sources})
    cell.write("tracerisk.lock", Lock().with_controller("pick.py", refused).dumps())
    said = "pick.py is not assessed as it is now: its last run is faulted, and wrote no blocks;"
    out = " ".join(cell.run("diff", "HEAD").out.split())
    assert said in out
    assert out.count("'jar' fell") == 1
    assert "and wrote no blocks; mend it, then `tracerisk refresh pick.py`." in out
    assert "writes them again" not in out
    assert "its blocks give" not in out
    comment = cell.run("diff", "HEAD", "--format", "markdown").out
    assert "| faulted, no blocks written |" in comment
    assert cell.run("diff", "HEAD", "--max-increase", "0.1").code == 1
    # Another change since: that run says nothing of it any more.
    cell.write("helper.py", "REACH = 0.6\n")
    assert "since its last run helper.py has changed" in " ".join(
        cell.run("diff", "HEAD").out.split()
    )
