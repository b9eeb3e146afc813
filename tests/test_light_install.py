"""What works where nothing but tracerisk and its base is installed, and what says what to add."""

import re
import subprocess
import sys
import venv
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import pytest

import tracerisk
from tests.slow import slow_but
from tracerisk.common.dependencies import EXTRAS, MODULES

SIMULATOR = "needs the simulator; install it: pip install 'tracerisk[sim]' [dependency]"
LARGE = (
    "samples, quantiles and large models need NumPy and SciPy; "
    "install them: pip install 'tracerisk[large]'"
)
MOST = 15

TANGLED = """
import random
from tracerisk.errors import DependencyError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind, minimal_cut_sets
from tracerisk.prm.trees.bdd import SharedTree
from tracerisk.prm.trees.bdd.diagram import Limits
from tracerisk.prm.numbers.probability import Probability

source = random.Random(7)
names = [f"e{i}" for i in range(24)]
gates = [Gate(f"g{i}", GateKind.OR, tuple(source.sample(names, 4))) for i in range(14)]
top = Gate("top", GateKind.AND, tuple(gate.name for gate in gates))
used = [name for name in names if any(name in gate.inputs for gate in gates)]
tree = FaultTree("top", (top, *gates), tuple(BasicEvent(name, "p") for name in used))
pairs = {name: Probability.of(0.01) for name in used}
"""
"""A product of sums over events drawn anew for each: no module, and a wide diagram."""

UNCOMPILED = """
from pathlib import Path
from tracerisk.prm.compiled import library
library.FILE = Path("nowhere")
"""


def base_distributions() -> list[str]:
    """The distributions that the base brings here, by what their metadata says."""
    left = [name for name in MODULES if not any(name in names for names in EXTRAS.values())]
    found: set[str] = set()
    while left:
        name = left.pop().lower()
        if name in found or (name == "tomli" and sys.version_info >= (3, 11)):
            continue
        found.add(name)
        requirements = [each for each in metadata.requires(name) or () if "extra" not in each]
        left += [re.split(r"[^\w.-]", each, maxsplit=1)[0] for each in requirements]
    return sorted(found)


@pytest.fixture(scope="module")
def light_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A Python that sees tracerisk and its base, and nothing else."""
    folder = tmp_path_factory.mktemp("light")
    venv.create(folder, symlinks=True, with_pip=False)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = folder / "lib" / version / "site-packages"
    (site / "tracerisk").symlink_to(Path(tracerisk.__file__).parent)
    for name in base_distributions():
        distribution = metadata.distribution(name)
        for top in {file.parts[0] for file in distribution.files or () if ".." not in file.parts}:
            if top != "__pycache__":
                (site / top).symlink_to(distribution.locate_file(top))
    return folder / "bin" / "python"


@pytest.fixture
def light(light_python: Path, example) -> Callable:
    return lambda *words: example.run(*words, python=light_python)


@pytest.fixture
def python(light_python: Path) -> Callable[[str], subprocess.CompletedProcess]:
    """Runs a program in the light environment."""
    return lambda program: subprocess.run(
        [light_python, "-c", program], capture_output=True, text=True, timeout=120
    )


@pytest.fixture
def annotated(example, annotated_source):
    source = annotated_source(
        home=("pick 1", "motor = 2e-7 x7"), pick=("done 1", "gripper := 1e-7")
    )
    example.write("cell.py", source)
    return example


def test_the_base_is_few_distributions():
    assert len(base_distributions()) + 1 <= MOST


@pytest.mark.slow(but=3)
@pytest.mark.parametrize(
    "words",
    slow_but(
        # A report solves and shows what the others do one by one.
        [
            ("build", "cell.py"),
            ("report", "cell.py", "-o", "out.html"),
            ("strip", "--discard-edits", "cell.py"),
            ("robots",),
            ("drivers", "list"),
            ("doctor",),
        ],
        [
            ("build", "cell.py"),
            ("solve", "cell.py"),
            ("solve", "cell.py", "--importance"),
            ("overrides", "cell.py"),
            ("report", "cell.py", "-o", "out.html"),
            ("strip", "--discard-edits", "cell.py"),
            ("robots",),
            ("drivers", "list"),
            ("completion", "bash"),
            ("doctor",),
        ],
        of_one=True,
    ),
    ids=" ".join,
)
def test_what_reads_blocks_works_with_the_base_alone(annotated, light, words):
    outcome = light(*words)
    assert outcome.code == 0, outcome.err
    if words[0] == "doctor":
        assert "extra sim: not installed: pip install 'tracerisk[sim]'" in outcome.out
        assert "extra large: not installed: pip install 'tracerisk[large]'" in outcome.out


def test_check_says_what_the_whole_installation_says(annotated, light):
    light_reported, reported = light("check", "cell.py"), annotated.run("check", "cell.py")
    assert (light_reported.code, light_reported.out) == (reported.code, reported.out)
    assert light_reported.code in (0, 1)


def test_diff_compares_versions_with_the_base_alone(repository, annotated_source, light_python):
    def cell(figure: str) -> str:
        return annotated_source(home=("done 1", f"motor = {figure} x7"))

    repository.write("cell.py", cell("2e-7"))
    repository.commit()
    repository.write("cell.py", cell("3e-7"))
    outcome = repository.run("diff", python=light_python)
    assert (outcome.code, outcome.err.count("Traceback")) == (0, 0), outcome.err
    assert "mission failure" in outcome.out
    assert outcome.out == repository.run("diff").out


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("words", "purpose"),
    [
        (("run", "bare.py"), "running a controller"),
        pytest.param(("trace", "bare.py"), "running a controller", marks=pytest.mark.slow),
        (("scenario", "bare.py"), "`tracerisk scenario`"),
        (("robots", "panda"), "`tracerisk robots`"),
        (("hardware", "init", "--robot", "panda"), "`tracerisk hardware`"),
        (("doctor", "bare.py"), "`tracerisk doctor`"),
    ],
    ids=lambda each: each[0] if isinstance(each, tuple) else "",
)
def test_what_needs_the_simulator_says_how_to_install_it_in_one_line(
    example, light, words, purpose
):
    example.write("bare.py", "def home(arm):\n    arm.go()\n\n\nhome(None)\n")
    before = example.files()
    outcome = light(*words)
    assert outcome.code == 2, outcome.err
    assert outcome.err == f"tracerisk: {purpose} {SIMULATOR}\n"
    assert example.files() == before


def test_a_folder_of_the_workspace_is_not_taken_for_the_simulator(example, light):
    example.write("bare.py", "def home(arm):\n    arm.go()\n")
    example.write("mujoco/arm.xml", "<mujoco/>\n")
    assert light("run", "bare.py").err == f"tracerisk: running a controller {SIMULATOR}\n"


def test_what_is_wrong_with_a_fault_is_said_before_what_is_missing(example, light):
    example.write("bare.py", "def home(arm):\n    arm.go()\n")
    assert "expected UNIT:MODE@SECONDS" in light("run", "bare.py", "--fault", "nonsense").err


def test_it_is_json_where_that_was_asked_for(example, light):
    example.write("bare.py", "def home(arm):\n    arm.go()\n")
    outcome = light("run", "bare.py", "--json")
    assert (outcome.code, outcome.json["error"]["code"]) == (2, "dependency")


def test_several_stale_controllers_are_reported_once(annotated, light):
    annotated.write("other.py", annotated.read("cell.py"))
    outcome = light("refresh", "cell.py", "other.py")
    assert (outcome.code, outcome.err.count("tracerisk[sim]")) == (2, 1), outcome.err


def test_writing_blocks_of_a_log_says_what_to_install(example, light):
    example.write("bare.py", "def home(arm):\n    arm.go()\n")
    example.write("cell.log", "Function:home()\nActiveComponents:motor\n\nCallSequence:home()\n")
    figure = "{value: 9.5e-08, per: visit}"
    example.write(
        "cell.yaml",
        f'components:\n  motor: {{probability: {figure}, quantity: 7, twin: {{joints: "*"}}}}\n',
    )
    outcome = light("annotate", "bare.py", "--log", "cell.log", "--hardware", "cell.yaml")
    assert outcome.code == 2
    assert outcome.err.splitlines()[-1].endswith(SIMULATOR), outcome.err


def test_samples_say_what_to_install(annotated, light):
    outcome = light("solve", "cell.py", "--uncertainty")
    assert outcome.code == 2
    assert outcome.err.splitlines()[-1] == f"tracerisk: {LARGE} [dependency]"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("program", "expected"),
    [
        (
            "import tracerisk as t; from pathlib import Path\n"
            "c = t.load_controller(Path('bare.py')); t.trace_controller(c, t.load_settings(c))",
            "running a controller needs the simulator; install it: pip install 'tracerisk[sim]'",
        ),
        (
            "from tracerisk.prm import MarkovChain\n"
            "n = 20_001\n"
            "rows = {str(i): {str(i + 1): 0.5, str(i // 2): 0.5} for i in range(1, n)}\n"
            "MarkovChain.of({'0': {'1': 1.0}, **rows}).solve('0')",
            LARGE,
        ),
        (
            "from tracerisk.prm.numbers.distributions import *\n"
            "from tracerisk.prm.numbers.arrays import np\nnp.zeros(3)",
            LARGE,
        ),
    ],
)
def test_the_python_api_raises_the_same(python, tmp_path, monkeypatch, program, expected):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare.py").write_text("def home(arm):\n    arm.go()\n")
    done = python(program)
    assert done.stderr.splitlines()[-1] == f"tracerisk.errors.DependencyError: {expected}"


def test_a_large_tree_has_the_same_figures_without_the_compiled_loops(python):
    program = TANGLED + (
        "shared = SharedTree(tree, Limits())\n"
        "print(repr(shared.probability(pairs)), max(d.size for d in shared.diagrams.values()))\n"
        "print(minimal_cut_sets(tree).count_by_order())\n"
    )
    light = python(UNCOMPILED + program)
    whole = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120
    )
    assert light.returncode == 0, light.stderr
    assert light.stdout == whole.stdout


def test_a_tree_that_would_take_too_long_as_python_says_how_to_compile_the_loops(python):
    program = TANGLED + "SharedTree(tree, Limits(nodes=(60, 600_000)))"
    assert python(UNCOMPILED + program).stderr.splitlines()[-1] == (
        "tracerisk.errors.DependencyError: a tree of this size needs the compiled loops, which "
        "this installation of tracerisk lacks; install a C compiler, then reinstall: pip install --force-reinstall --no-binary tracerisk tracerisk"
    )


def test_a_controller_of_python_2_says_which_extra_reads_it(example, light):
    example.write("cell.py", "def f():\n    # | RiskAnnotation\n    print 1\n")
    outcome = light("strip", "cell.py")
    assert outcome.code == 2
    assert outcome.err.strip() == (
        "tracerisk: reading a source of Python 2 needs fissix; install it: "
        "pip install 'tracerisk[python2]'"
        " [dependency]"
    )


def test_a_description_in_sysml_says_which_extra_reads_it(example, light):
    example.write("cell.sysml", "package Cell {}\n")
    outcome = light("hardware", "show", "cell.sysml")
    assert outcome.code == 2
    assert outcome.err.strip() == (
        "tracerisk: a hardware description in SysML v2 needs lark; install it: "
        "pip install 'tracerisk[sysml]'"
        " [dependency]"
    )
