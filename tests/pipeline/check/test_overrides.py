import re

import pytest

from tests.pipeline.check.test_check_misses_nothing import block
from tracerisk.adder.annotate import SourceBlocks, annotate_sources
from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.common.function_ref import QualifiedName
from tracerisk.pipeline.check.overrides import overrides_in


class Cell:
    """Sources with blocks, and a lock that knows them."""

    def __init__(self, folder) -> None:
        self.folder = folder
        self.lock = Lock()
        (folder / "pyproject.toml").write_text("")

    def write(self, controller: str, **functions: tuple[str, str]) -> None:
        """Write the blocks of a run: by function, its file and what follows it."""
        sources = []
        for file in dict.fromkeys([controller, *(file for file, _ in functions.values())]):
            path = self.folder / file
            if not path.exists():
                own = [name for name, (place, _) in functions.items() if place == file]
                path.write_text("\n\n".join(f"def {name}():\n    go()\n" for name in own))
            computed = {
                QualifiedName(name): block(name, rank, following)
                for rank, (name, (place, following)) in enumerate(functions.items(), start=1)
                if place == file
            }
            sources.append(SourceBlocks(file, path.read_bytes(), computed))
        outcome = annotate_sources(
            controller, sources, self.lock, fingerprint="", trace={}, policy=MergePolicy()
        )
        for source in outcome.sources:
            (self.folder / source.file).write_bytes(source.after)
        self.lock = outcome.lock
        (self.folder / "tracerisk.lock").write_bytes(self.lock.dumps())

    def read(self, file: str) -> str:
        return (self.folder / file).read_text()

    def set(self, file: str, pattern: str, new: str) -> None:
        """Replace a text in a file, once."""
        text, count = re.subn(pattern, new, self.read(file), count=1)
        assert count == 1
        (self.folder / file).write_text(text)


@pytest.fixture
def cell(tmp_path) -> Cell:
    return Cell(tmp_path)


def test_no_function_of_another_file_is_taken_for_a_renamed_one(cell):
    cell.write("c.py", home=("m.py", "leave"), leave=("c.py", "done"))
    cell.set("c.py", "next = done 1", "next := home 1  ! computed done 1; FMEA-112")
    copied = cell.read("m.py").replace("home", "rest")
    (cell.folder / "c.py").write_text(f"{copied}\n\n{cell.read('c.py')}")
    (override,) = overrides_in([cell.folder / "c.py"])
    assert override.value == "home 1"


def test_what_each_controller_wrote_into_a_module_is_known(cell):
    module = "def home():\n    go()\n\n\ndef turn():\n    go()\n"
    (cell.folder / "m.py").write_text(module)
    cell.write("a.py", home=("m.py", "done"))
    before = cell.read("m.py")
    (cell.folder / "m.py").write_text(module)
    cell.write("b.py", turn=("m.py", "done"))
    (cell.folder / "m.py").write_text(
        before.partition("def turn")[0] + cell.read("m.py").partition("\n\n\n")[2]
    )
    cell.set("m.py", r"def turn", "def rest")
    cell.set("m.py", r"(def rest.*\n.*RiskAnnotation) \S+", r"\1")
    cell.set("m.py", r"(name = turn\n(?:.*\n)*?.*)next = done 1", r"\1next := done 1  ! by me")
    (override,) = overrides_in([cell.folder / "m.py"])
    assert override.field == "rest.next"
    assert override.computed == "done 1"
