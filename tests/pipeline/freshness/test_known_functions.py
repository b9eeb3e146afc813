"""Functions that settings and blocks name, and a function whose name is taken."""

import pytest

STEPS = """\
from lib.moves import push


def done(arm):
    arm.go()


def home(arm):
    arm.go()


class Cell:
    def place(self):
        def inner():
            pass
"""
LOG = """\
Function:home()
ActiveComponents:motor
Function:done()
ActiveComponents:motor

CallSequence:home(),done(),home(),done()
"""
HARDWARE = """\
components:
  motor: {probability: {value: 9.5e-08, per: visit}, quantity: 7, twin: {joints: "*"}}
"""
ANNOTATE = ("annotate", "cell.py", "--log", "run.log", "--hardware", "arm.yaml")


@pytest.fixture
def cell(example):
    example.write("cell.py", STEPS)
    example.write("run.log", LOG)
    example.write("arm.yaml", HARDWARE)
    example.write("lib/moves.py", "def push(arm):\n    arm.go()\n")
    return example


SHARED = "[tool.tracerisk]\n{} = ['{}']\n"
OWN = "[tool.tracerisk]\nseed = 1\n[tool.tracerisk.controllers.'cell.py']\nseed = 2\n{} = ['{}']\n"


@pytest.mark.parametrize("key", ["states", "helpers"])
@pytest.mark.parametrize(("table", "line"), [(SHARED, 2), (OWN, 5)])
def test_a_name_that_is_no_function_is_an_error_with_its_line(key, table, line, cell):
    cell.write("pyproject.toml", table.format(key, "hoem"))
    before = cell.files()
    outcome = cell.run(*ANNOTATE)
    assert outcome.code == 2
    assert outcome.err == (
        f"tracerisk: pyproject.toml:{line}: {key}: cell.py and its modules have no function "
        "'hoem'; did you mean 'home'? allowed: <module>, Cell.place, "
        "Cell.place.<locals>.inner, done, home [settings]\n"
    )
    assert cell.files() == before


@pytest.mark.parametrize("name", ["home", "Cell.place", "Cell.place.<locals>.inner", "<module>"])
def test_a_function_of_the_controller_is_none(name, cell):
    cell.write("pyproject.toml", OWN.format("helpers", name))
    assert cell.run(*ANNOTATE).code == 0


def test_what_all_controllers_share_may_name_a_function_of_another(cell):
    cell.write("other.py", "def elsewhere():\n    pass\n")
    cell.write(".hidden/other.py", "def hidden():\n    pass\n")
    cell.write("env/pyvenv.cfg", "")
    cell.write("env/other.py", "def installed():\n    pass\n")
    cell.write("broken.py", "def broken(:\n")
    cell.write("pyproject.toml", SHARED.format("helpers", "elsewhere"))
    assert cell.run(*ANNOTATE).code == 0
    for name in ("hidden", "installed", "broken"):
        cell.write("pyproject.toml", SHARED.format("helpers", name))
        assert f"no function '{name}'" in cell.run(*ANNOTATE).err
    cell.write("pyproject.toml", OWN.format("helpers", "elsewhere"))
    assert "no function 'elsewhere'" in cell.run(*ANNOTATE).err


def test_the_name_is_reported_before_a_run(cell):
    cell.write("pyproject.toml", SHARED.format("states", "hoem"))
    outcome = cell.run("run", "cell.py")
    assert (outcome.code, "pyproject.toml:2: states:" in outcome.err) == (2, True)


def test_of_many_functions_the_message_lists_some(cell):
    cell.write("cell.py", STEPS + "".join(f"def f{n:03}():\n    pass\n" for n in range(300)))
    cell.write("pyproject.toml", SHARED.format("states", "f2O7"))
    outcome = cell.run(*ANNOTATE)
    assert "did you mean 'f2" in outcome.err
    assert outcome.err.rstrip().endswith("f015 and 285 more [settings]")


def test_a_function_called_done_is_reported_from_the_end_of_the_mission(cell):
    assert cell.run(*ANNOTATE).code == 0
    text = cell.read("cell.py").decode()
    assert "name = done\n" in text
    assert text.count("next = cell.done 1\n") == 1
    assert "next = home 1/2\n    # |   next = done 1/2\n" in text
    built = cell.run("solve", "cell.py", "--json").json["assessment"]["states"]
    assert [state["name"] for state in built] == ["home", "cell.done"]
    assert cell.run("check", "cell.py").code == 0
    assert cell.run(*ANNOTATE).err.startswith("cell.py: 2 risk blocks, unchanged")
