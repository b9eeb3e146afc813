"""`run --live -- COMMAND`: which source an executable was built from, and what names none."""

import shutil
import subprocess
from argparse import Namespace

import pytest

from tracerisk.cli.running.live_command import name_source

NODE = "int main() { return 0; }\n"
needs_compiler = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("addr2line") is None, reason="no g++ or binutils"
)


@pytest.fixture
def node(tmp_path, example_in):
    """A project with a source, which is no node: all refusals come before one is needed."""
    example = example_in(tmp_path)
    example.write("pyproject.toml", "")
    example.write("src/pick.cpp", NODE)
    return example


def built(example, *flags):
    source = str(example.folder / "src/pick.cpp")
    subprocess.run(["g++", *flags, source, "-o", str(example.folder / "pick")], check=True)


@needs_compiler
def test_an_executable_with_debug_information_names_its_source(node):
    built(node, "-g")
    done = node.run("trace", "--live", "--robot", "nope", "--", "./pick", "--left")
    assert done.code == 2
    assert "unknown robot 'nope'" in done.err or "rospy and rosmaster" in done.err
    (node.folder / "src/pick.cpp").rename(node.folder / "src/moved.cpp")
    done = node.run("trace", "--live", "--", "./pick", "--left")
    assert done.code == 2
    assert "src/pick.cpp, which is not there: build it again, or name the source" in done.err


@needs_compiler
def test_ros2_run_of_an_executable_names_its_source(node, monkeypatch):
    monkeypatch.chdir(node.folder)
    (node.folder / "install/lib/far").mkdir(parents=True)
    built(node, "-g")
    (node.folder / "pick").rename(node.folder / "install/lib/far/pick")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(node.folder / "install"))
    words = ["run", "far", "pick", "--left"]
    options = Namespace(live=True, controller="ros2", argv=words, verb="run")
    name_source(options)
    assert (options.controller, options.argv) == ("src/pick.cpp", ["ros2", *words])


@needs_compiler
def test_an_executable_without_it_needs_a_name(node):
    built(node, "-s")
    done = node.run("run", "--live", "--", "./pick", "--left")
    assert done.code == 2
    assert "./pick does not say from which source it was built: compile with -g" in done.err
    assert "`tracerisk run FILE.cpp --live -- ./pick --left`" in done.err


@pytest.mark.parametrize("begin", [b"\x7fELF\x02\x01", b"\x7fELF\x02\x01" + b"\xff" * 99])
def test_a_file_that_begins_as_an_executable_and_is_none_is_refused(node, begin):
    (node.folder / "pick").write_bytes(begin)
    (node.folder / "pick").chmod(0o755)
    done = node.run("run", "--live", "--", "./pick")
    assert done.code == 2
    assert "./pick does not say from which source it was built" in done.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--live", "--", "cell.launch"), "cell.launch is neither a Python program nor the exec"),
        (("--live", "--", "./gone"), "the program ./gone is not there; build it"),
        (("src/pick.cpp",), "--live runs its node on the twin"),
        (("src/pick.cpp", "--live"), "whose node is started by a command"),
        (("src/other.cpp", "--live", "--", "true"), "has no main(); name the source in which"),
        (("src/pick.cpp", "--live", "--", "./gone"), "the program ./gone of the command is not"),
    ],
)
def test_what_does_not_say_what_to_run_is_refused(node, arguments, message):
    node.write("cell.launch", "<launch/>")
    node.write("src/other.cpp", "void pick() {}\n")
    done = node.run("trace", *arguments)
    assert done.code == 2
    assert message in " ".join(done.err.split())


NODE_OF_ROS2 = "import rclpy\nrclpy.init()\n"


@pytest.fixture
def package(tmp_path, example_in):
    """A package of ROS 2 whose executable is an entry point, and a script beside it."""
    example = example_in(tmp_path)
    example.write("cell/package.xml", "<package><name>cell</name></package>")
    example.write("cell/setup.py", "entry_points={'console_scripts': ['pick = cell.picking:main']}")
    example.write("cell/cell/picking.py", NODE_OF_ROS2)
    example.write("cell/cell/other.py", NODE_OF_ROS2)
    return example


@pytest.mark.parametrize(
    ("command", "controller", "arguments"),
    [
        (["ros2", "run", "cell", "pick", "--left"], "cell/cell/picking.py", ["--left"]),
        (["ros2", "run", "cell", "other"], "cell/cell/other.py", []),
        (["python3", "cell/cell/other.py", "-x"], "cell/cell/other.py", ["-x"]),
        (["/usr/bin/python3.11", "cell/cell/other.py"], "cell/cell/other.py", []),
        (["cell/cell/other.py", "-x"], "cell/cell/other.py", ["-x"]),
    ],
)
def test_a_command_in_python_names_its_script(package, monkeypatch, command, controller, arguments):
    monkeypatch.chdir(package.folder)
    options = Namespace(live=True, controller=command[0], argv=command[1:], verb="run")
    name_source(options)
    assert (options.controller, options.argv) == (controller, arguments)


def test_an_installed_script_is_found_by_its_prefix(package, monkeypatch):
    monkeypatch.chdir(package.folder)
    package.write("install/lib/far/turn", "#!/usr/bin/env python3\n" + NODE_OF_ROS2)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(package.folder / "install"))
    options = Namespace(live=True, controller="ros2", argv=["run", "far", "turn"], verb="run")
    name_source(options)
    assert options.controller == "install/lib/far/turn"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["ros2", "run", "cell", "nothing"], "no executable nothing of a package cell is below"),
        (
            ["ros2", "run", "far", "built"],
            "install/lib/far/built does not say from which source it was built",
        ),
        (["ros2", "launch", "cell", "cell.launch.py"], "FILE.py --live --launch FILE"),
        (["ros2", "run", "cell"], "takes `ros2 run PACKAGE EXECUTABLE ARGUMENTS`"),
        (["python3", "-m", "cell.picking"], "takes the path of a script and its arguments"),
    ],
)
def test_a_command_of_ros2_that_names_no_script_is_refused(package, monkeypatch, command, message):
    (package.folder / "install/lib/far").mkdir(parents=True)
    (package.folder / "install/lib/far/built").write_bytes(b"\x7fELF\x02")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(package.folder / "install"))
    done = package.run("run", "--live", "--", *command)
    assert done.code == 2
    assert message in " ".join(done.err.split())
