"""The compiled loops: built where there is a compiler, used where they fit, the same to the bit."""

import ctypes
import importlib.util
import random
import re
import shutil
import subprocess
import sys
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import pytest

from tracerisk.prm.compiled import library
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.cut_sets import family, minimal_cut_sets
from tracerisk.prm.trees.bdd import SharedTree, bounds, diagram
from tracerisk.prm.trees.bdd.bounds import tree_bounds
from tracerisk.prm.trees.bdd.diagram import Limits
from tracerisk.prm.trees.bdd.speed import fastest_loops, plain_loops
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

ROOT = Path(__file__).parents[3]
SOURCES = ROOT / "tracerisk" / "prm" / "compiled"
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def hatch_build():
    pytest.importorskip("hatchling", reason="hatchling is not installed")
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def wide_tree(seed, events, sums):
    """A product of sums over events drawn anew for each, a few of them complements."""
    source = random.Random(seed)
    names = [f"e{i}" for i in range(events)]
    nots = [Gate(f"n{name}", GateKind.NOT, (name,)) for name in names[:3]]
    drawn = [*names[3:], *(gate.name for gate in nots)]
    gates = [Gate(f"g{i}", GateKind.OR, tuple(source.sample(drawn, 4))) for i in range(sums)]
    top = Gate("top", GateKind.AND, tuple(gate.name for gate in gates))
    used = {name for gate in gates for name in gate.inputs}
    nots = [gate for gate in nots if gate.name in used]
    used |= {name for gate in nots for name in gate.inputs}
    events = tuple(BasicEvent(name) for name in names if name in used)
    return FaultTree("top", (top, *gates, *nots), events)


def figures(tree):
    """Everything that a loop computes of a tree, in hexadecimal."""
    source = random.Random(1)
    pairs = {event.name: Probability.of(source.uniform(0.0, 0.4)) for event in tree.events}
    half = {name: Probability.of(pair.p / 2) for name, pair in pairs.items()}
    solver = SharedTree(tree)
    limits = Limits(nodes=(20,), bound_nodes=30)
    sets = minimal_cut_sets(tree, max_order=6)
    values = {name: pair.p for name, pair in pairs.items()}
    numbers = [
        *solver.probability(pairs),
        *solver.sensitivities(pairs).values(),
        solver.difference(pairs, half),
        *tree_bounds(tree, pairs, limits),
        *sets.count_by_order().values(),
        sets.rare_event_sum(values),
        *(each.probability for each in islice(sets.most_probable(values), 20)),
    ]
    return [float(number).hex() for number in numbers]


@pytest.mark.parametrize("seed", range(4))
def test_every_loop_gives_the_same_bits_compiled_and_as_python(seed):
    tree = wide_tree(seed, 16, 10)
    compiled = figures(tree)
    with (
        patch.object(diagram, "fastest_loops", plain_loops),
        patch.object(bounds, "fastest_loops", plain_loops),
        patch.object(family, "fastest_loops", plain_loops),
    ):
        assert figures(tree) == compiled


@needs_compiler
def test_the_loops_are_compiled_where_there_is_a_compiler():
    assert library.library() is not None, "run `python hatch_build.py`: the loops are not compiled"
    assert fastest_loops() is not plain_loops()


def test_one_version_is_said_on_both_sides():
    text = (SOURCES / "version.c").read_text(encoding="utf-8")
    assert re.findall(r"loops_version = (\d+);", text) == [str(library.VERSION)]


@pytest.fixture
def afresh():
    """The library is looked for anew, here and in the next test."""
    library.library.cache_clear()
    yield
    library.library.cache_clear()


@pytest.mark.usefixtures("afresh")
def test_a_library_that_is_none_or_is_missing_is_not_used(monkeypatch, tmp_path):
    monkeypatch.setattr(library, "FILE", tmp_path / "loops.so")
    assert library.library() is None
    library.library.cache_clear()
    (tmp_path / "loops.so").write_bytes(b"\x7fELF of another machine")
    assert library.library() is None


@needs_compiler
@pytest.mark.usefixtures("afresh")
def test_a_library_of_another_version_is_not_used(monkeypatch, tmp_path):
    monkeypatch.setattr(library, "FILE", tmp_path / "loops.so")
    (tmp_path / "old.c").write_text(f"const int loops_version = {library.VERSION + 1};\n")
    command = ["cc", "-shared", "-fPIC", tmp_path / "old.c", "-o", tmp_path / "loops.so"]
    subprocess.run(command, check=True)
    assert library.library() is None


@needs_compiler
def test_the_sources_compile_without_a_warning_and_without_python(tmp_path):
    made = tmp_path / "loops.so"
    strict = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror")
    command = ["cc", *strict, "-O1", "-shared", "-fPIC", *SOURCES.glob("*.c"), "-o", made]
    subprocess.run(command, check=True)
    ctypes.CDLL(str(made))
    assert b"Py_" not in made.read_bytes()


def made_files(hatch_build):
    pytest.importorskip("argparse_manpage")
    metadata = SimpleNamespace(version="0.1.0")
    return hatch_build.MadeFiles(str(ROOT), {}, None, metadata, "", "wheel")


@needs_compiler
def test_a_wheel_is_for_the_machine_that_its_loops_were_compiled_on(hatch_build, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    hook = made_files(hatch_build)
    data = {"extra_metadata": {}, "force_include": {}, "shared_data": {}}
    hook.initialize("standard", data)
    places = {place: made for made, place in data["force_include"].items()}
    made = places["tracerisk/prm/compiled/loops.so"]
    assert Path(made).exists()
    assert data["pure_python"] is False
    assert re.fullmatch(r"py3-none-(manylinux_2_17|musllinux|macosx|linux)_\w+", data["tag"])
    hook.finalize("standard", data, "")
    assert not Path(made).exists()


@pytest.mark.parametrize("compiler", ["false", "no-such-compiler"])
def test_a_wheel_without_a_compiler_is_for_every_machine(hatch_build, monkeypatch, capfd, compiler):
    monkeypatch.setenv("CC", compiler)
    hook = made_files(hatch_build)
    data = {"extra_metadata": {}, "force_include": {}, "shared_data": {}}
    hook.initialize("standard", data)
    hook.finalize("standard", data, "")
    assert "tracerisk/prm/compiled/loops.so" not in data["force_include"].values()
    assert "tag" not in data
    assert "trees are solved by Python alone" in capfd.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")
def test_no_memory_for_a_diagram_is_a_memory_error():
    program = """
import resource
resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
from tracerisk.prm.compiled import library
try:
    library.integers(1 << 29)
except MemoryError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == f"{1 << 31} bytes for a decision diagram\n"
