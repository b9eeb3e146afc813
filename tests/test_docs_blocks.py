"""What docs/blocks.md shows is what happens."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tracerisk.adder.blocks.values import CALL_SEQUENCE, COMPONENT_KINDS, NEXT
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.merge import merge
from tracerisk.adder.sources.insert import in_form, insert_blocks
from tracerisk.adder.sources.read import read_blocks

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "docs" / "blocks.md").read_text(encoding="utf-8")

HARDWARE = """\
components:
  motor: {probability: {value: 9.5e-08, per: visit}, quantity: 7, twin: {joints: "*"}}
"""
LOG = "Function:home()\nActiveComponents:motor\n\nCallSequence:home()\n"


def fenced(language: str) -> str:
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    return text


def test_the_block_shown_is_read_and_would_be_written_as_it_is():
    source = fenced("python").encode()
    (placed,) = read_blocks(source, "blocks.md")
    assert placed.function == "place"
    assert insert_blocks(source, {"place": placed.block}, "blocks.md") == source
    gripper, hose, wrist = placed.block.components[1:]
    assert gripper.probability.computed == "7.344e-08"
    assert gripper.probability.reason.endswith("which also holds for the second batch")
    assert (hose.added, wrist.omitted) == (True, True)
    kept = merge(None, placed.block, None, policy=MergePolicy("discard")).block
    assert kept is not None
    (kept_gripper,) = [each for each in kept.components if each.name == "gripper"]
    assert kept_gripper.probability.text == "2e-07"


def test_the_compact_form_shown_says_the_same_as_the_published_one():
    source = fenced("python").encode()
    compact = in_form(source, "blocks.md", "compact").decode()
    lines = [line.strip() for line in compact.split("\n") if "# |" in line]
    example, grammar = re.findall(r"^```text\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    assert [line.rstrip() for line in example.splitlines()] == lines
    assert in_form(compact.encode(), "blocks.md", "published") == source
    assert {line.split()[0] for line in grammar.splitlines() if "=" in line[:12]} == {
        *(
            "block",
            "function",
            "step",
            "component",
            "mode",
            "outcome",
            "values",
            "units",
            "comment",
            "more",
        ),
    }


COMPACT_LINES = re.findall(
    r"^\| `([^`]+)` \|", TEXT.split("## The compact form")[1].split("\n## ")[0], re.MULTILINE
)


@pytest.mark.parametrize("line", COMPACT_LINES)
def test_each_line_of_the_compact_form_is_read(line):
    if line.startswith("place"):
        rows = [line]
    elif line.startswith("->"):
        rows = ["place 2", "gripper 2e-07 1", line]
    elif "!" in line:
        rows = ["place 2", "gripper := 2e-07 := 1 of 2 ! short", line]
        rows = [rows[0], f"{rows[1].partition('!')[0]}{line}"] if line.startswith("!") else rows
    else:
        rows = ["place 2", line]
    text = "".join(f"    # | {row}\n" for row in ["RiskAnnotation", *rows])
    (placed,) = read_blocks(f"def place():\n{text}    pass\n".encode(), "blocks.md")
    assert placed.block.form == "compact"


def test_every_line_of_a_block_is_explained():
    keys = {"name", CALL_SEQUENCE.key, NEXT.key, *(kind.key for kind in COMPONENT_KINDS)}
    assert set(re.findall(r"^\| `(\w+)` \| ", TEXT, re.MULTILINE)) == keys


def test_the_commands_shown_pass_on_a_fresh_controller(example):
    example.write("cell.py", "def home():\n    pass\n")
    example.write("arm.yaml", HARDWARE)
    example.write("run.log", LOG)
    options = ("--log", "run.log", "--hardware", "arm.yaml")
    assert example.run("annotate", "cell.py", *options).code == 0
    commands = [shlex.split(line) for line in fenced("sh").splitlines()]
    assert len(commands) == 3
    for program, *arguments in commands:
        assert program == "tracerisk"
        outcome = example.run(*arguments)
        assert outcome.code == 0, outcome.err


def test_the_hooks_shown_are_those_there_are(tmp_path):
    config = YAML(typ="safe").load(fenced("yaml"))
    hooks = YAML(typ="safe").load((ROOT / ".pre-commit-hooks.yaml").read_bytes())
    (shown,) = config["repos"]
    assert {hook["id"] for hook in shown["hooks"]} == {hook["id"] for hook in hooks}
    program = Path(sys.executable).parent / "pre-commit"
    if not program.exists():
        pytest.skip("pre-commit is not installed")
    path = tmp_path / ".pre-commit-config.yaml"
    path.write_text(fenced("yaml"))
    done = subprocess.run([program, "validate-config", path], capture_output=True, check=False)
    assert done.returncode == 0, done.stdout
