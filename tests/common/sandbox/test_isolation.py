"""Our own processes import what is ours; what a controller legitimately does works contained."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk.api import trace_controller
from tracerisk.common.limits import DEFAULT_LIMITS, Sandbox
from tracerisk.common.sandbox.kernel.features import Support, support
from tracerisk.common.sandbox.process import SandboxWarning, is_contained, start
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.config import Settings
from tracerisk.errors import RobotError, SandboxError
from tracerisk.pipeline.launch_files.process import read_launch
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.project import Project
from tracerisk.twin.urdf.xacro_files import expand_xacro

contained = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")

CELL = """\
import asyncio, csv, json, logging, os, pathlib, shutil, socket, subprocess, tempfile
import numpy, rospy, moveit_commander
import poses

HERE = os.path.dirname(os.path.abspath(__file__))

def main():
    rospy.init_node("cell")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    joints = arm.get_current_joint_values()
    joints[0] += poses.STEP + json.load(open(os.path.join(HERE, "cell.json")))["step"]
    arm.go(joints, wait=True)
    logging.basicConfig(filename="run.log", level=logging.INFO)
    logging.info("moved")
    with open("steps.csv", "w", newline="") as file:
        csv.writer(file).writerow([1, 2])
    assert next(csv.reader(open("steps.csv"))) == ["1", "2"]
    numpy.savetxt("way.csv", [[1.0, 2.0]])
    assert numpy.loadtxt("way.csv").tolist() == [1.0, 2.0]
    results = pathlib.Path(HERE, "results", "today")
    results.mkdir(parents=True)
    (results / "a.json").write_text("{}")
    assert sorted(os.listdir(results.parent)) == ["today"]
    assert {each.name for each in pathlib.Path(HERE).iterdir()} >= {"cell.py", "results"}
    with open(os.path.join(HERE, "cell.json"), "a") as file:
        file.write(" ")
    os.replace("steps.csv", "last.csv")
    assert not os.path.exists("steps.csv") and os.path.getsize("last.csv")
    shutil.copy2(os.path.join(HERE, "cell.json"), "copy.json")
    os.remove(os.path.join(HERE, "poses.py"))
    assert not pathlib.Path(HERE, "poses.py").exists()
    shutil.rmtree(results.parent)
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "x").write_text("x")
    one, other = socket.socketpair()
    one.send(b"x")
    assert other.recv(1) == b"x"

    async def wait():
        await asyncio.sleep(0.1)
        return await asyncio.get_running_loop().run_in_executor(None, lambda: 7)

    assert asyncio.run(wait()) == 7
    assert subprocess.run(["true"]).returncode == 0
    assert subprocess.check_output(["echo", "x"]) == b"x\\n"
    arm.go(joints, wait=True)

if __name__ == "__main__":
    main()
"""


def write_cell(folder: Path) -> Path:
    (folder / "poses.py").write_text("STEP = 0.01\n")
    (folder / "cell.json").write_text('{"step": 0.01}')
    (folder / "cell.py").write_text(CELL)
    return folder / "cell.py"


@contained
def test_what_controllers_do_works_contained_and_changes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write_cell(tmp_path)
    before = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    trace = trace_controller(load_controller(path), Settings(sandbox="require"))
    assert trace.end.cause == "ended", trace.end
    assert [each.kind for each in trace.findings] == []
    assert {each.name: each.read_bytes() for each in tmp_path.iterdir()} == before


@contained
def test_a_trace_is_the_same_contained_or_not(tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path / "there")
    traces = []
    for number, mode in enumerate(("require", "off")):
        folder = tmp_path / f"{number}" / "cell"
        folder.mkdir(parents=True)
        path = write_cell(folder)
        # Uncontained it would be gone.
        path.write_text(
            CELL.replace('os.remove(os.path.join(HERE, "poses.py"))', "pass").replace(
                'assert not pathlib.Path(HERE, "poses.py").exists()', "pass"
            )
        )
        traces.append(trace_controller(load_controller(path), Settings(sandbox=mode)))
    assert traces[0] == traces[1]


@contained
def test_what_settings_name_is_reached(tmp_path, monkeypatch):
    monkeypatch.setenv("CELL", "7")
    cell, data = tmp_path / "cell", tmp_path / "data"
    for each in (cell, data, cell / "logs"):
        each.mkdir()
    (data / "pose.json").write_text("1")
    (cell / "cell.py").write_text(
        "import os, rospy, moveit_commander\n"
        'arm = moveit_commander.MoveGroupCommander("panda_arm")\n'
        'arm.set_named_target("ready")\narm.go(wait=True)\n'
        f'open("{cell}/logs/a", "w").write(open("{data}/pose.json").read() + os.environ["CELL"])\n'
    )
    (cell / "pyproject.toml").write_text(
        '[tool.tracerisk]\nreadable = ["../data"]\nwritable = ["logs"]\nenv = ["CELL"]\n'
    )
    controller = load_controller(cell / "cell.py")
    settings = ProjectSettings(cell).of("cell.py")
    assert trace_controller(controller, settings).end.cause == "ended"
    assert (cell / "logs" / "a").read_text() == "17"
    # Required on the command line, no file of the workspace widens it.
    trace = trace_controller(controller, settings.with_options({"sandbox": "require"}))
    assert trace.end.cause == "raised", trace.end
    assert trace.verdict is not None
    assert "access-denied" in {each.code for each in trace.verdict.reasons}, (
        trace.end,
        trace.findings,
    )


@pytest.mark.parametrize("name", ["site-packages", "scripts"])
def test_only_the_script_of_a_kernel_lies_among_what_is_imported(tmp_path, monkeypatch, name):
    folder = tmp_path / name
    folder.mkdir()
    (folder / "seen_here.py").write_text("print('imported')")
    monkeypatch.setattr(sys, "argv", [str(folder / "ipykernel_launcher.py")])
    monkeypatch.syspath_prepend(str(folder))
    child = start(
        "seen_here",
        sandbox=Sandbox("off" if support().missing else "require"),
        environment={},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    out, _ = child.communicate(timeout=60)
    assert out.decode().split() == (["imported"] if name == "site-packages" else [])


def test_modules_of_the_current_folder_are_none_of_ours(tmp_path):
    for name in ("queue", "json", "ruamel", "numpy", "tracerisk"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a module of the folder ran')\n")
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "cell.py").write_text(
        "import moveit_commander\n"
        'arm = moveit_commander.MoveGroupCommander("panda_arm")\n'
        'arm.set_named_target("ready")\narm.go(wait=True)\n'
    )
    code = "import sys; from tracerisk.cli import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-I", "-c", code, "trace", "cell/cell.py", "--json"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["exit_code"] == 0


LAUNCH_ATTACKS = {
    "rename": "os.rename(HERE + '/victim', OUT)",
    "link": "os.link(HERE + '/victim', OUT)",
    "symlink": "os.symlink(HERE + '/victim', OUT)",
    "fifo": "os.mkfifo(OUT)",
    "system": "ctypes.CDLL(None).system(b'touch ' + OUT.encode())",
    "sqlite": "sqlite3.connect(OUT).execute('create table t(a)')",
    "fork": "__import__('subprocess').Popen(['touch', OUT])",
    "environment": "open('/proc/self/environ').read(); found.append('environ')",
    "token": "found.extend(k for k in os.environ if 'TOKEN' in k)",
    "datagram": "socket.socket(2, 2).sendmsg([b'x'], [], 0, ('127.0.0.1', 9)); found.append('udp')",
}


@contained
@pytest.mark.parametrize(
    "names",
    [
        pytest.param([*LAUNCH_ATTACKS], id="all"),
        *(pytest.param([each], id=each, marks=pytest.mark.slow) for each in LAUNCH_ATTACKS),
    ],
)
def test_a_launch_file_does_nothing_but_describe(tmp_path, monkeypatch, names):
    monkeypatch.setenv("SECRET_TOKEN", "x")
    outside = tmp_path / "outside"
    outside.mkdir()
    package = tmp_path / "ws" / "launch"
    package.mkdir(parents=True)
    (package.parent / "package.xml").write_text("<package><name>ws</name></package>")
    (package / "victim").write_text("x")
    (package / "json.py").write_text(f"open({str(outside / 'json')!r}, 'w')\n")
    tried = "".join(
        f"    try:\n        {LAUNCH_ATTACKS[each]}\n    except Exception:\n        pass\n"
        for each in names
    )
    (package / "go.launch.py").write_text(
        "import ctypes, os, socket, sqlite3\n"
        "from launch import LaunchDescription\nfrom launch_ros.actions import Node\n"
        f"OUT, HERE, found = {str(outside / 'new')!r}, os.path.dirname(__file__), []\n"
        f"def generate_launch_description():\n{tried}"
        "    return LaunchDescription([Node(package='ws', executable='x', arguments=found)])\n"
    )
    read = read_launch(package / "go.launch.py", Project(package.parent).workspace())
    assert [each.arguments for each in read.nodes] == [()], read.problems
    assert list(outside.iterdir()) == []
    assert (package / "victim").read_text() == "x"


@contained
def test_a_macro_reads_nothing_of_the_home(tmp_path, monkeypatch):
    secret = tmp_path / "home" / ".ssh" / "key.yaml"
    secret.parent.mkdir(parents=True)
    secret.write_text("a: SECRET")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "model").mkdir()
    model = tmp_path / "model" / "arm.xacro"
    model.write_text(
        '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        f"<link name=\"${{xacro.load_yaml('{secret}')['a']}}\"/></robot>"
    )
    with pytest.raises(RobotError, match="load_yaml"):
        expand_xacro(model, {})
    uncontained = replace(DEFAULT_LIMITS, sandbox=Sandbox("off"))
    assert b"SECRET" in expand_xacro(model, {}, limits=uncontained)


@pytest.mark.slow
@contained
def test_a_contained_controller_runs_what_is_contained_itself(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xacro").write_text(
        '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="n" value="base"/><link name="${n}"/></robot>'
    )
    (tmp_path / "cell.py").write_text(
        "import subprocess, moveit_commander\n"
        'arm = moveit_commander.MoveGroupCommander("panda_arm")\n'
        'arm.set_named_target("ready")\narm.go(wait=True)\n'
        'print(subprocess.check_output(["xacro", "arm.xacro"]))\n'
    )
    trace = trace_controller(load_controller(tmp_path / "cell.py"), Settings(sandbox="require"))
    assert trace.end.cause == "ended", trace.end
    assert '<link name="base"/>' in capfd.readouterr().err


def test_a_kernel_without_it_is_warned_of_once_and_refused_where_it_is_required(monkeypatch):
    from tracerisk.common.sandbox import process

    monkeypatch.setattr(process, "support", lambda: Support(0, seccomp=True))
    process._warn_once.cache_clear()
    with pytest.warns(SandboxWarning, match="Landlock .* is missing") as reported:
        assert [is_contained(Sandbox()) for _ in range(2)] == [False, False]
    assert len(reported) == 1
    assert not is_contained(Sandbox("off"))
    with pytest.raises(SandboxError, match="required and does not work here"):
        is_contained(Sandbox("require"))
