"""What `check` finds names the command that mends it, and the command does."""

import re
import shlex
from pathlib import Path
from typing import get_args

import pytest

from tests.cli.conftest import annotated, annotated_run, hardware, two_steps  # noqa: F401
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.errors import Location
from tracerisk.pipeline.check.finding import CheckFinding, FindingKind
from tracerisk.pipeline.check.remedies import MENDED_BY_REFRESH, with_remedy
from tracerisk.pipeline.check.run import verdict_findings
from tracerisk.pipeline.workspace.controller import load_controller

NAME = "controller.py"


def changed(example, old: str, new: str, count: int = 1) -> None:
    text = example.read(NAME).decode()
    assert old in text
    example.write(NAME, text.replace(old, new, count))


def other_code(example):
    changed(example, "    home(arm)\n", "    print('home')\n    home(arm)\n")


def other_setting(example):
    example.write("pyproject.toml", "[tool.tracerisk]\nseed = 3\n")


def value_edited(example):
    text = example.read(NAME).decode()
    example.write(NAME, re.sub(r"probability = \S+", "probability = 1e-3", text, count=1))


def block_lost(example):
    lines = example.read(NAME).decode().splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if "RiskAnnotation" in line)
    last = first
    while lines[last].lstrip().startswith("# |"):
        last += 1
    example.write(NAME, "".join(lines[:first] + lines[last:]))


def function_renamed(example):
    changed(example, "home(", "rest(", count=-1)


def lock_lost(example):
    (example.folder / "tracerisk.lock").unlink()


def next_lost(example):
    text = example.read(NAME).decode()
    example.write(NAME, re.sub(r"\n *# \|   next = .*", "", text, count=1))


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("change", "kind", "option"),
    [
        (other_code, "stale", ""),
        (other_setting, "stale", ""),
        (value_edited, "edited", " --discard-edits"),
        (value_edited, "edited", " --accept-edits"),
        (block_lost, "missing", ""),
        (next_lost, "missing", ""),
        (function_renamed, "orphaned", ""),
        (lock_lost, "unknown", ""),
    ],
)
def test_the_command_that_is_named_mends_it(annotated, change, kind, option):  # noqa: F811
    change(annotated)
    before = annotated.run("check", NAME)
    assert before.code in (1, 3)
    lines = [line for line in before.out.splitlines() if f": {kind}: " in line]
    assert lines, before.out
    for line in lines:
        assert named(line), line
        if option:
            assert option.strip() in line
    done = annotated.run(*shlex.split(named(lines[0]).partition(" --")[0] + option)[1:])
    assert done.code == 0, done.err
    assert annotated.run("check", NAME).code == 0


def named(line: str) -> str:
    """The command in a line that is about the controller."""
    commands = re.findall(r"`(tracerisk (?:refresh|run) [^`]+)`", line)
    return commands[0] if commands else ""


def test_a_file_whose_name_a_shell_would_split_is_quoted(annotated):  # noqa: F811
    text = annotated.read(NAME)
    annotated.write("my cell.py", text)
    (annotated.folder / NAME).unlink()
    outcome = annotated.run("check", "my cell.py")
    assert "`tracerisk refresh 'my cell.py'`" in outcome.out + outcome.err


@pytest.mark.parametrize("kind", get_args(FindingKind))
@pytest.mark.parametrize("file", ["cell.py", "cell.cpp"])
def test_each_kind_says_what_to_do(kind, file):
    finding = CheckFinding(kind, "something", Location(file, 1), remedy="")
    said = with_remedy(finding, Path(file)).text
    assert said.startswith("something; ")
    if kind in MENDED_BY_REFRESH:
        verb = r"(refresh|run)" if file.endswith(".py") else "annotate"
        assert re.search(rf"`tracerisk {verb} {re.escape(file)}", said), said


def test_json_has_the_remedy_by_itself(annotated):  # noqa: F811
    other_code(annotated)
    (finding,) = annotated.run("check", NAME, "--json").json["findings"]
    assert finding["remedy"] == f"`tracerisk refresh {NAME}`"
    assert finding["remedy"] not in finding["message"]


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        ("command-replaced", "mend it, then `tracerisk run {file} --live -- COMMAND`"),
        ("input-assumed", "give what a user types by --answer TEXT, or mend it, then `tracerisk "),
        ("robot-assumed", "`tracerisk run {file} --robot NAME --live -- COMMAND`"),
    ],
)
def test_a_compiled_node_runs_by_its_command_alone(tmp_path, monkeypatch, code, remedy):
    monkeypatch.chdir(tmp_path)
    Path("pyproject.toml").touch()
    Path("pick.cpp").write_text("int main() { return 0; }\n")
    verdict = Verdict("partial", (Reason(code, "partial", "so it was"),))
    (finding,) = verdict_findings(load_controller(Path("pick.cpp")), verdict)
    assert finding.remedy.startswith(remedy.format(file="pick.cpp"))


def test_a_changed_description_that_no_refresh_can_read_is_the_error(example):
    wrong = "components:\n  motor: {probability: {value: 2, per: visit}, twin: {joints: '*'}}\n"
    example.write("arm.yaml", wrong.replace("2, per", "2e-07, per"))
    example.write("run.log", "Function:home()\nActiveComponents:motor\n\nCallSequence:home()\n")
    example.write("cell.py", "def home(arm):\n    arm.go()\n")
    written = example.run("annotate", "cell.py", "--log", "run.log", "--hardware", "arm.yaml")
    assert written.code == 0, written.err
    example.write("arm.yaml", wrong)
    outcome = example.run("check", "cell.py")
    assert outcome.code == 2
    assert "arm.yaml:2:" in outcome.out
    assert "[hardware]" in outcome.out
    example.write("arm.yaml", wrong.replace("2, per", "3e-07, per"))
    assert "stale: arm.yaml has changed" in example.run("check", "cell.py").out
