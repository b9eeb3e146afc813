"""`run --live -- COMMAND`: which source an executable was built from, and what names none."""

import shutil
import subprocess

import pytest

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
