"""What annotated files mean to other tools, and what reading them costs."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

from tracerisk.adder.insert import insert_blocks


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


@pytest.mark.parametrize(
    "module", ["block", "grammar", "read", "lock", "merge", "insert", "write", "annotate"]
)
def test_importing_the_adder_loads_nothing_heavy(module: str) -> None:
    code = (
        f"import sys, tracerisk.adder.{module}\n"
        "print(*sorted({'libcst', 'numpy', 'mujoco', 'dm_control', 'yaml', 'rich'}"
        " & set(sys.modules)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stdout.strip() == ""


def test_reading_and_removing_blocks_needs_no_libcst(annotated: Path) -> None:
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from tracerisk.adder.insert import insert_blocks, strip_blocks\n"
        "from tracerisk.adder.read import read_blocks\n"
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
