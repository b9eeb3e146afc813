"""Controllers that are installed as a command: what starts them."""

import pytest

from tests.conftest import quick_controller
from tracerisk.pipeline.workspace.entry_point import EntryPoint, find_entry_point

NODE = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray


class Mover(Node):
    def __init__(self):
        super().__init__("mover")
        self.commands = self.create_publisher(Float64MultiArray, "/arm_controller/commands", 1)
        self.create_timer(1.0, self.tick)

    def tick(self):
        joints = [f"panda_joint{i}" for i in range(1, 8)]
        amount = 0.1 * len(joints)
        self.commands.publish(Float64MultiArray(data=[amount] * 3 + [-amount] + [amount] * 3))
        raise SystemExit(0)


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Mover())
"""
SETUP = """\
from setuptools import setup
package = "arm_task"
setup(name=package, entry_points={"console_scripts": ["mover = " + package + ".mover:main"]})
"""
PYPROJECT = '[project]\nname = "arm_task"\n[project.scripts]\nmover = "arm_task.mover:start"\n'


@pytest.mark.parametrize(
    "line",
    [
        '"mover = arm_task.mover:main",',
        "'mover=arm_task.mover:main',",
        "'mover = ' + package + '.mover:main',",
        "f'mover = {package}.mover:main',",
    ],
)
def test_setup_py_names_the_function(tmp_path, line):
    (tmp_path / "setup.py").write_text(f"entries = [{line}]\n")
    found = find_entry_point(tmp_path / "mover.py", b"def main(args=None): pass\n", tmp_path)
    assert found == EntryPoint("main", "setup.py")


def test_setup_cfg_and_pyproject_name_it_too(tmp_path):
    source = b"def main(): pass\ndef start(): pass\n"
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    script = tmp_path / "mover.py"
    assert find_entry_point(script, source, tmp_path) == EntryPoint("start", "pyproject.toml")
    (tmp_path / "setup.cfg").write_text(
        "[options.entry_points]\nconsole_scripts =\n    mover = arm_task.mover:main\n"
    )
    assert find_entry_point(script, source, tmp_path) == EntryPoint("main", "setup.cfg")


def test_an_entry_is_called_though_the_module_makes_its_constants_by_functions(tmp_path):
    (tmp_path / "setup.py").write_text("entries = ['mover = arm_task.mover:main']\n")
    source = b"def above(z):\n    return z + 0.1\nHIGH = above(0.2)\ndef main(): pass\n"
    script = tmp_path / "mover.py"
    assert find_entry_point(script, source, tmp_path) == EntryPoint("main", "setup.py")
    assert find_entry_point(script, source + b"main()\n", tmp_path) is None


def test_another_modules_entry_is_not_taken(tmp_path):
    (tmp_path / "setup.py").write_text("entries = ['a = arm_task.other:start']\n")
    assert find_entry_point(tmp_path / "mover.py", b"def start(): pass\n", tmp_path) is None


@pytest.mark.parametrize(
    "source",
    [
        "def main(): pass\nif __name__ == '__main__':\n    main()\n",
        "def main(): pass\nmain()\n",
        "def main(): pass\nclass Node: pass\nnode = Node()\n",
        "def main(robot): pass\n",
        "def main(*, robot): pass\n",
        "def move(): pass\n",
        "import rospy\nrospy.sleep(1)\n",
        "def main(:\n",
    ],
)
def test_what_starts_by_itself_or_cannot_be_called_is_left_alone(tmp_path, source):
    assert find_entry_point(tmp_path / "mover.py", source.encode(), tmp_path) is None


@pytest.mark.parametrize(
    "source",
    [
        "import logging\nlog = logging.getLogger(__name__)\ndef main(): pass\n",
        "def helper(): main()\ndef main(*args, robot='a', **more): pass\n",
    ],
)
def test_a_main_that_nothing_calls_is_called(tmp_path, source):
    found = find_entry_point(tmp_path / "mover.py", source.encode(), tmp_path)
    assert found == EntryPoint("main", None)


def test_a_node_without_a_guard_runs_as_its_command_would(example):
    example.write("src/arm_task/package.xml", "<package><name>arm_task</name></package>\n")
    example.write("src/arm_task/setup.py", SETUP)
    example.write("src/arm_task/arm_task/__init__.py", "")
    example.write("src/arm_task/arm_task/mover.py", NODE)
    outcome = example.run("run", "src/arm_task/arm_task/mover.py", "--json", "--robot", "panda")
    assert outcome.code == 0, outcome.err
    assert [each["ref"]["name"] for each in outcome.json["trace"]["functions"]] == ["Mover.tick"]
    text = "start: main() of the script, named in setup.py, was called"
    assert text in outcome.json["assumptions"]


def test_a_module_off_the_import_path_is_found_in_the_workspace_and_reported(example):
    example.write("src/arm_task/package.xml", "<package><name>arm_task</name></package>\n")
    example.write("src/vendor/package.xml", "<package><name>vendor</name></package>\n")
    example.write("src/vendor/imp/VENDOR_init.py", "AMOUNT = 0.2\n")
    script = NODE.replace("import rclpy\n", "import VENDOR_init\nimport rclpy\n", 1)
    script = script.replace("0.1 *", "VENDOR_init.AMOUNT / 2 *")
    example.write("src/arm_task/arm_task/mover.py", script)
    outcome = example.run("run", "src/arm_task/arm_task/mover.py", "--json", "--robot", "panda")
    assert outcome.code == 0, outcome.err
    text = "import: VENDOR_init was taken from ../vendor/imp, which is not on the import path"
    assert text in outcome.json["assumptions"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("script", "imported", "module", "more"),
    [
        ("src/tasks/pick.py", "src.tools.amounts", "src/tools/amounts.py", "pyproject.toml"),
        ("src/tasks/pick.py", "src.tools.amounts", "src/tools/amounts.py", "README.md"),
        ("lab/tasks/pick.py", "shared.amounts", "shared/amounts.py", "README.md"),
        ("scripts/pick.py", "amounts", "amounts.py", "README.md"),
    ],
)
def test_a_script_runs_as_from_the_top_of_its_repository(example, script, imported, module, more):
    example.write(more, "")
    example.write(module, "AMOUNT = 0.05\n")
    source = quick_controller("joints[0] += AMOUNT", "arm.go(joints, wait=True)")
    example.write(script, source.replace("import ", f"from {imported} import AMOUNT\nimport ", 1))
    outcome = example.run("run", script, "--json")
    assert outcome.code == 0, outcome.err
    name = imported.partition(".")[0]
    told = [each for each in outcome.json["assumptions"] if each.startswith(f"import: {name} ")]
    assert len(told) == 1
    assert "which is not on the import path" in told[0]
