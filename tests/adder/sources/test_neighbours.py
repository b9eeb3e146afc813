"""What annotated files mean to other tools, and what reading them costs."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

from tests.slow import slow_but
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.read import read_blocks


@pytest.fixture
def annotated(tmp_path: Path, read_block) -> Path:
    block = read_block(
        f"""
        RiskAnnotation
        @Function {{
          name = Picker.place
          callSequence = 5
          next = init 9/10
          next = done 1/10
        }}
        @Component {{
          name = gripper
          probability := 2e-07  ! computed 7.344e-08; {"the supplier derates it " * 9}
          quantity = 1
          redundancy = false
        }}
        """
    )
    source = dedent(
        '''\
        """Pick."""


        class Picker:
            """Picks."""

            def place(self) -> None:
                """Place."""
                self.placed = True
        '''
    )
    path = tmp_path / "pick.py"
    script = read_block("RiskAnnotation\n@Function {\nname = <module>\ncallSequence = 1\n}")
    blocks = {"Picker.place": block, "<module>": script}
    path.write_bytes(insert_blocks(source.encode(), blocks, "pick.py"))
    return path


def run_tool(*command: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which(command[0], path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip(f"{command[0]} is not installed")
    return subprocess.run(
        [program, *command[1:]], capture_output=True, text=True, check=False, timeout=60
    )


def test_ruff_finds_nothing_in_a_block_and_takes_it_for_no_dead_code(annotated: Path) -> None:
    ignored = "D203,D213,INP,CPY"
    command = ("ruff", "check", "--isolated", "--no-cache", "--preview", "--select", "ALL")
    report = run_tool(*command, "--ignore", ignored, str(annotated))
    assert report.stdout.strip() == "All checks passed!"


def test_ruff_sees_dead_code_in_the_same_lines_without_the_gutter(annotated: Path) -> None:
    annotated.write_bytes(annotated.read_bytes().replace(b"# | ", b"# "))
    report = run_tool(
        "ruff", "check", "--isolated", "--no-cache", "--select", "ERA001", str(annotated)
    )
    assert "ERA001" in report.stdout


@pytest.mark.parametrize(
    "command",
    [("ruff", "format", "--isolated", "--no-cache"), ("black", "-q"), ("eradicate", "-i")],
)
def test_formatters_leave_an_annotated_file_as_it_is(
    command: tuple[str, ...], annotated: Path
) -> None:
    before = annotated.read_bytes()
    run_tool(*command, str(annotated))
    assert annotated.read_bytes() == before


HARD = '''\
"""Cell."""

import asyncio


def one_line(): pass


async def wait() -> None:
    """Wait."""
    await asyncio.sleep(1)


class Cell:
    """A cell."""

    class Arm:
        """Its arm."""

        @property
        def ready(self) -> bool:
            return self.state == 1

        def plan(self, goals: list[int]) -> list[int]:
            def inner(goal: int) -> int:
                # The goal is taken twice.
                return goal * 2

            return [inner(goal) for goal in goals]


def f(goal: int) -> int:
    if goal:
        while True:

            def g() -> int:
                if goal:

                    def h() -> int:
                        if goal:

                            def i() -> int:
                                return goal

                            return i()
                        return 0

                    return h()
                return 0

            return g()
    return 0


def documented() -> str:
    """
    Return a text.

    It is short.
    """
    # text = documented()
    return "x"
'''
NAMES = (
    "<module>",
    "one_line",
    "wait",
    "Cell.Arm.ready",
    "Cell.Arm.plan",
    "Cell.Arm.plan.<locals>.inner",
    "f.<locals>.g.<locals>.h.<locals>.i",
    "documented",
)
REASONS = {
    "long": "the supplier derates it " * 20,
    "code": "x = 1; y = foo(x), print(y); if x: return {'a': 1}; import os; def f(): pass",
    "a link": f"see https://example.org/{'fmea/' * 20}112 for the batch",
    "words of linters": "TODO: ask; FIXME later; XXX; HACK; type: ignore; pragma: no cover; pylint",
    "numbers": "12.5 % of 7 # 3, see FMEA-112 (rev. 4), 'batch 9' \"spring\" [2, 3]",
    "brackets": "} @Component { | ! computed 3; := omit",
}


def dressed(read_block, reason: str, name: str, rank: int):
    """A block with a person's word wherever there may be one."""
    return read_block(
        f"""
        RiskAnnotation
        @Function {{
          name = {name}
          callSequence := {rank}  ! computed 1; {reason}
          next := init 0.25  ! computed init 9/10, done 1/10; {reason}
          next := done 0.75
        }}
        @Component {{
          name = electric motor of the third joint
          probability := 2e-07  ! computed 7.344e-08; {reason}
          quantity = 7
          redundancy := true  ! computed false
        }}
        @Component := {{  ! {reason}
          name = hose
          probability = 1e-06
          quantity = 2
          redundancy = true
        }}
        @Component := omit {{  ! {reason}
          name = brake
        }}
        """
    )


def annotate_hard(source: bytes, read_block, reason: str) -> bytes:
    blocks = {
        name: dressed(read_block, reason, name, rank) for rank, name in enumerate(NAMES, start=1)
    }
    return insert_blocks(source, blocks, "cell.py")


@pytest.mark.parametrize("indent", ["    ", "\t"], ids=["spaces", "tabs"])
@pytest.mark.parametrize(
    "newline", ["\n", pytest.param("\r\n", marks=pytest.mark.slow)], ids=["LF", "CRLF"]
)
@pytest.mark.parametrize("reason", REASONS)
def test_ruff_reports_nothing_in_any_line_of_a_block(
    reason: str, newline: str, indent: str, tmp_path: Path, read_block
) -> None:
    text = HARD.replace("    ", indent).replace("\n", newline)
    path = tmp_path / "cell.py"
    path.write_bytes(annotate_hard(text.encode(), read_block, REASONS[reason]))
    placed = read_blocks(path.read_bytes(), "cell.py")
    assert len(placed) == len(NAMES)
    inside = {line for block in placed for line in range(block.first_line, block.last_line + 1)}
    # A block is indented as the body of its function is; the notice is asked of the whole file.
    ignored = "D,ANN,INP,CPY,W191,E101" if indent == "\t" else "D,ANN,INP,CPY"
    options = ("--isolated", "--no-cache", "--output-format", "json", "--select", "ALL")
    report = run_tool("ruff", "check", *options, "--ignore", ignored, str(path))
    found = json.loads(report.stdout)
    assert "ERA001" in {each["code"] for each in found}, "dead code of the source's own"
    of_blocks = [
        (each["code"], each["location"]["row"], each["message"])
        for each in found
        if inside & set(range(each["location"]["row"], each["end_location"]["row"] + 1))
        and each["location"]["row"] in inside
    ]
    assert of_blocks == []


FORMATTERS = {
    "ruff": ("ruff", "format", "--isolated", "--no-cache"),
    "ruff, narrow": ("ruff", "format", "--isolated", "--no-cache", "--line-length", "40"),
    "ruff, import order": ("ruff", "check", "--isolated", "--no-cache", "--select", "I", "--fix"),
    "ruff, fixes": (
        *("ruff", "check", "--isolated", "--no-cache", "--select", "ERA,E,W,RUF,TD,FIX,C,PIE,D"),
        *("--fix", "--unsafe-fixes", "--preview", "--quiet", "--exit-zero"),
    ),
    "black": ("black", "-q"),
    "black, preview": ("black", "-q", "--preview"),
    "black, narrow": ("black", "-q", "--line-length", "40"),
    "eradicate": ("eradicate", "-i"),
    "eradicate, aggressive": ("eradicate", "-i", "--aggressive"),
}


@pytest.mark.parametrize(
    "tool",
    slow_but(
        ["ruff, narrow", "ruff, import order", "ruff, fixes", "black", "eradicate"],
        list(FORMATTERS),
    ),
)
def test_what_a_tool_would_leave_it_leaves_with_blocks_too(
    tool: str, tmp_path: Path, read_block
) -> None:
    path = tmp_path / "cell.py"
    path.write_text(HARD)
    # Some need two goes until they leave a source alone.
    for _ in range(2):
        assert run_tool(*FORMATTERS[tool], str(path)).returncode == 0
    reason = " and ".join(REASONS.values())
    annotated = annotate_hard(path.read_bytes(), read_block, reason)
    path.write_bytes(annotated)
    assert run_tool(*FORMATTERS[tool], str(path)).returncode == 0
    assert path.read_bytes().decode() == annotated.decode()


OF_THE_ADDER = (
    *("blocks.block", "blocks.grammar", "sources.read", "lock.lock", "merge.merge"),
    *("sources.insert", "sources.write", "annotate"),
)


def test_importing_the_adder_loads_nothing_heavy() -> None:
    """One process imports one after the other, and says what is there after each."""
    code = (
        "import sys\nfrom importlib import import_module\n"
        "for name in sys.argv[1:]:\n"
        "    import_module(f'tracerisk.adder.{name}')\n"
        "    heavy = {'libcst', 'numpy', 'mujoco', 'dm_control', 'yaml', 'rich'}\n"
        "    print(name, *sorted(heavy & set(sys.modules)))\n"
    )
    command = [sys.executable, "-c", code, *OF_THE_ADDER]
    found = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert found.stdout.splitlines() == [*OF_THE_ADDER]


def test_reading_and_removing_blocks_needs_no_libcst(annotated: Path) -> None:
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from tracerisk.adder.sources.insert import insert_blocks, strip_blocks\n"
        "from tracerisk.adder.sources.read import read_blocks\n"
        "source = Path(sys.argv[1]).read_bytes()\n"
        "blocks = {b.function: b.block for b in read_blocks(source, 'pick.py')}\n"
        "assert len(blocks) == 2\n"
        "assert insert_blocks(source, blocks, 'pick.py') == source\n"
        "assert len(strip_blocks(source, 'pick.py')) < len(source)\n"
        "print('libcst' in sys.modules)"
    )
    found = subprocess.run(
        [sys.executable, "-c", code, str(annotated)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert found.stdout.strip() == "False"
