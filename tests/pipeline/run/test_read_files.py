"""Files of the workspace that a controller opens itself: they are inputs of its run."""

import hashlib
import json
import py_compile
import zipfile

import pytest

from tests.conftest import quick_controller

_HERE = "here = os.path.dirname(os.path.abspath(__file__))"
_TURNS = "for _ in range(turns): arm.go(joints, wait=True)"
# Of each way: the file, and what reads a number from it.
_READS = {
    "open": ("plan.json", "import json; turns = json.load(open(os.path.join(here, 'plan.json')))"),
    "os.open": ("plan.bin", "turns = int(os.read(os.open(b'plan.bin', os.O_RDONLY), 9))"),
    "numpy": ("plan.csv", "import numpy; turns = int(numpy.loadtxt(here + '/plan.csv'))"),
    "pathlib": ("data/plan", "import pathlib; turns = int(pathlib.Path('data/plan').read_text())"),
    "update": ("plan.txt", "stream = open('plan.txt', 'r+'); turns = int(stream.read())"),
    "rospkg": (
        "config/plan.yaml",
        "import rospkg, yaml; own = rospkg.RosPack().get_path('cell'); "
        "turns = yaml.safe_load(open(own + '/config/plan.yaml'))",
    ),
}
_PACKAGE = "<package><name>cell</name><buildtool_depend>catkin</buildtool_depend></package>"


def _files(example) -> dict[str, str]:
    lock = json.loads(example.read("tracerisk.lock"))
    (entry,) = lock["controllers"].values()
    return entry["inputs"]["files"]


@pytest.fixture(scope="module")
def of_reader(tmp_path_factory, example_in):
    """The folder of a controller that has read a file in each way, once it has run."""
    example = example_in(tmp_path_factory.mktemp("reader"))
    for name, _ in _READS.values():
        example.write(name, "2\n")
    example.write("package.xml", _PACKAGE)
    reads = [f"{read}; assert turns == 2" for _, read in _READS.values()]
    example.write("c.py", quick_controller(_HERE, *reads, _TURNS))
    ran = example.run("run", "c.py")
    assert ran.code == 0, ran.err
    assert example.run("report", "c.py", "--dossier", "d").code == 0
    return example


def test_what_a_controller_reads_and_nothing_else_is_an_input(of_reader):
    assert set(_files(of_reader)) == {name for name, _ in _READS.values()}
    assert of_reader.run("check", "c.py").code == 0


@pytest.mark.parametrize("how", _READS)
def test_a_file_that_the_controller_reads_is_in_a_dossier_and_its_change_shows(of_reader, how):
    name, _ = _READS[how]
    with zipfile.ZipFile(of_reader.folder / "d") as archive:
        assert archive.read(f"files/{name}") == b"2\n"
        assert f'"{name}"' in archive.read("record.json").decode()
    of_reader.write(name, "5\n")
    outcome = of_reader.run("check", "c.py")
    of_reader.write(name, "2\n")
    assert outcome.code == 1
    assert f"{name} has changed" in outcome.out + outcome.err


def test_what_the_run_wrote_itself_and_a_log_are_none(example):
    example.write("c.log", "earlier\n")
    example.write(
        "c.py",
        quick_controller(
            "open('c.log', 'a').write('now')",
            "open('own.txt', 'w').write('1'); assert open('own.txt').read() == '1'",
            "os.close(os.open('c.log', os.O_WRONLY | os.O_APPEND))",
            "open(__file__).read(); os.path.exists('absent')",
        ),
    )
    for options in ((), ("--fresh", "--sandbox", "off")):
        example.run("run", "c.py", *options)
        assert _files(example) == {}


_BESIDE = {
    "src/mine/.git/HEAD": "ref: refs/heads/main\n",
    "src/mine/plan.txt": "2",
    "src/mine/cell/package.xml": _PACKAGE,
    "src/tools/.git/HEAD": "ref: refs/heads/main\n",
    "src/tools/arm_tools/package.xml": _PACKAGE.replace("cell", "arm_tools"),
    "src/tools/arm_tools/turns.txt": "2",
    "src/other/unrelated/package.xml": _PACKAGE.replace("cell", "unrelated"),
}


@pytest.mark.slow
def test_contained_or_not_it_has_the_same_inputs_and_no_neighbour_is_one(example):
    for name, text in _BESIDE.items():
        example.write(name, text)
    example.write(
        "src/mine/cell/c.py",
        "import os, rospkg, rospy, moveit_commander\n"
        "rospy.init_node('cell')\n"
        "tools = rospkg.RosPack().get_path('arm_tools')\n"
        "turns = int(open(os.path.join(tools, 'turns.txt')).read())\n"
        "turns += int(open(os.path.join(os.path.dirname(__file__), '../plan.txt')).read())\n"
        "arm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "for _ in range(turns): arm.go([0.1, 0, 0, -1, 0, 1, 0], wait=True)\n",
    )
    path = "src/mine/cell/c.py"
    contained = example.run("trace", path, "--sandbox", "auto", "--json").json
    inputs = contained["trace"]["inputs"]
    assert [name for name in inputs if not name.endswith(".py")] == [
        "../../tools/arm_tools/turns.txt",
        "../plan.txt",
    ]
    assert contained == example.run("trace", path, "--sandbox", "off", "--json").json


def test_a_variable_that_the_settings_name_is_an_input(example, monkeypatch):
    example.write("pyproject.toml", '[tool.tracerisk]\nenv = ["TURNS", "OTHER"]\n')
    example.write("c.py", quick_controller("turns = int(os.environ['TURNS'])", _TURNS))
    monkeypatch.setenv("TURNS", "2")
    example.run("run", "c.py")
    digest = hashlib.sha256(b"TURNS=2").hexdigest()
    (entry,) = json.loads(example.read("tracerisk.lock"))["controllers"].values()
    assert entry["inputs"]["variables"] == {"OTHER": "unset", "TURNS": digest}
    assert example.run("check", "c.py").code == 0
    assert example.run("report", "c.py", "--dossier", "d").code == 0
    with zipfile.ZipFile(example.folder / "d") as archive:
        guide = archive.read("README.md").decode()
    assert f"`OTHER` (not set), `TURNS` (set, {digest[:12]})" in guide
    assert "Set the environment variables `OTHER`, `TURNS` as they were" in guide
    for value, words in (("6", "has another value"), (None, "is not set any more")):
        monkeypatch.delenv("TURNS") if value is None else monkeypatch.setenv("TURNS", value)
        outcome = example.run("check", "c.py")
        assert outcome.code == 1
        assert f"environment variable TURNS {words}" in outcome.out + outcome.err
    monkeypatch.setenv("TURNS", "2")
    monkeypatch.setenv("OTHER", "")
    assert "environment variable OTHER is set now" in example.run("check", "c.py").out


_TURNS_OF = "import turns_of; turns = turns_of.TURNS"


def _compiled(example, name: str, text: str) -> None:
    example.write("turns_of.py", text)
    source = example.folder / "turns_of.py"
    py_compile.compile(str(source), str(example.folder / name), dfile="turns_of.py", doraise=True)
    source.unlink()


def _zipped(example, name: str, text: str) -> None:
    path = example.folder / name
    path.parent.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("turns_of.py", text)


# Of each way to have a module without a source in the workspace: its file, what writes it, and what
# is on `PYTHONPATH`.
_MODULES = {
    "compiled": ("turns_of.pyc", _compiled, ""),
    "on the path": (
        "../beside/turns_of.py",
        lambda example, name, text: example.write(name, text),
        "../beside",
    ),
    "zipped on the path": ("../beside/turns.zip", _zipped, "../beside/turns.zip"),
    "read and executed": (
        "turns_of.py",
        lambda example, name, text: example.write(name, text),
        "",
    ),
}


@pytest.mark.parametrize("how", _MODULES)
def test_code_that_a_run_loads_is_an_input_wherever_it_is(example_in, tmp_path, monkeypatch, how):
    (tmp_path / "cell").mkdir()
    (tmp_path / "beside").mkdir()
    example = example_in(tmp_path / "cell")
    name, write, on_path = _MODULES[how]
    write(example, name, "TURNS = 2\n")
    if on_path:
        monkeypatch.setenv("PYTHONPATH", str((example.folder / on_path).resolve()))
    executed = "names = {}; exec(open(here + '/turns_of.py').read(), names); turns = names['TURNS']"
    example.write(
        "c.py",
        quick_controller(_HERE, executed if how == "read and executed" else _TURNS_OF, _TURNS),
    )
    ran = example.run("run", "c.py")
    assert ran.code == 0, ran.err
    assert set(_files(example)) == {name}
    assert example.run("check", "c.py").code == 0
    assert example.run("report", "c.py", "--dossier", "d").code == 0
    with zipfile.ZipFile(example.folder / "d") as archive:
        packed = [file for file in archive.namelist() if file.endswith(name.rpartition("/")[2])]
        told = archive.read("assumptions.md").decode()
    assert len(packed) == 1
    assert (f"import: {name} " in told) == (how != "read and executed")
    write(example, name, "TURNS = 5\n")
    outcome = example.run("check", "c.py")
    assert outcome.code == 1
    assert f"{name} has changed" in outcome.out + outcome.err


def test_what_a_run_reads_outside_of_the_workspace_is_an_input(example_in, tmp_path):
    for folder in ("cell", "beside/site-packages"):
        (tmp_path / folder).mkdir(parents=True)
    example = example_in(tmp_path / "cell")
    names = ("../beside/plan.txt", "../beside/site-packages/plan.txt", "../one.txt")
    for name in names:
        example.write(name, "2\n")
    readable = [str(tmp_path / name) for name in ("beside", "one.txt")]
    example.write("pyproject.toml", f"[tool.tracerisk]\nreadable = {readable}\n")
    reads = [f"turns = int(open(here + '/{name}').read())" for name in names]
    example.write("c.py", quick_controller(_HERE, *reads, _TURNS))
    for options in ((), ("--fresh", "--sandbox", "off")):
        ran = example.run("run", "c.py", *options)
        assert ran.code == 0, ran.err
        assert set(_files(example)) == set(names)
    example.write(names[0], "5\n")
    outcome = example.run("check", "c.py")
    assert (outcome.code, f"{names[0]} has changed" in outcome.out + outcome.err) == (1, True)


def test_what_changes_the_python_of_a_run_is_told_and_its_figure_is_out_of_date_without_it(
    example, tmp_path, monkeypatch
):
    example.write("site/sitecustomize.py", "import math\nmath.expm1 = lambda x: 0.1 * x\n")
    example.write("c.py", quick_controller())
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    ran = example.run("run", "c.py", "--json")
    assert ran.code == 0, ran.err
    (told,) = [line for line in ran.json["assumptions"] if "sitecustomize" in line]
    assert "changed the Python in which tracerisk computes" in told
    assert example.run("check", "c.py").code == 0
    monkeypatch.delenv("PYTHONPATH")
    outcome = example.run("check", "c.py")
    assert outcome.code == 1
    assert "what PYTHONPATH changes in Python was ['sitecustomize" in outcome.out
