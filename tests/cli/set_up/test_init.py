"""`tracerisk init`: what a repository needs, shown first, written once, and never over a file."""

import json
import os
import pty
import re
import select
import shutil
import subprocess
import sys
from argparse import Namespace
from importlib import metadata
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tests.conftest import program
from tracerisk.cli.set_up import init
from tracerisk.pipeline.start.ci_files import ci_files, template

SAMPLES = Path(__file__).parents[3] / "sample_controllers"
TUTORIAL = (SAMPLES.parent / "docs/tutorial.md").read_text(encoding="utf-8")


@pytest.fixture
def cell(repository, quick):
    repository.write("src/pick.py", quick())
    repository.write("src/helper.py", "import math\n\ndef f(x):\n    return math.sin(x)\n")
    repository.write("tests/fake.py", "import rospy\n\nrospy.init_node('x')\n")
    return repository


def files(repository):
    return {
        path.relative_to(repository.folder).as_posix(): path.read_bytes()
        for path in repository.folder.rglob("*")
        if path.is_file() and ".git" not in path.relative_to(repository.folder).parts
    }


def test_it_shows_what_it_would_write_and_writes_nothing_unasked(cell):
    before = files(cell)
    outcome = cell.run("init", "--ci", "github")
    assert outcome.code == 0, outcome.err
    assert "1 controller found" in outcome.out
    assert "src/pick.py" in outcome.out
    assert "robot: panda" in outcome.out
    for name in ("hardware.yaml", "pyproject.toml", ".pre-commit-config.yaml", "risk.yml"):
        assert name in outcome.out
    assert "Nothing was written" in outcome.out
    assert files(cell) == before


def test_it_says_which_components_its_hardware_file_counts_beside_the_shipped_ones(cell):
    said = " ".join(cell.run("init", "--yes").out.split())
    assert (
        "hardware.yaml: failure data, to be replaced by your own value by value; beside what is "
        "counted without the file it has encoder and torque_sensor with assumed figures, so risk "
        "figures rise with the next run"
    ) in said
    described = YAML(typ="safe").load(cell.read("hardware.yaml"))["components"]
    assert {"encoder", "torque_sensor"} <= set(described)
    again = cell.run("init", "--yes").out
    assert "torque_sensor" not in again


def test_it_shows_what_it_would_set_up_for_git(cell):
    shown = cell.run("init").out.partition("To write:\n")[2]
    assert "  .gitattributes: by which git merges tracerisk.lock by controllers\n" in shown
    assert (
        "  .git/config: by which git merges tracerisk.lock in this clone, with tracerisk\n" in shown
    )
    before = set(files(cell))
    outcome = cell.run("init", "--yes", "--json").json
    assert set(outcome["files"]) == {*files(cell)} - before | {".git/config"}
    assert "merge=tracerisk-lock" in cell.read(".gitattributes").decode()
    (cell.folder / ".pre-commit-config.yaml").unlink()
    assert ".gitattributes" not in cell.run("init").out


def test_the_hook_that_it_prints_for_git_alone_is_the_one_of_the_tutorial(cell):
    said = cell.run("init", "--yes").out
    command = re.search(r"this is the hook: (printf .*)", said)[1]
    assert command == " && ".join(
        line for line in TUTORIAL.splitlines() if ".git/hooks/pre-commit" in line
    )
    subprocess.run(command, shell=True, cwd=cell.folder, check=True)
    hook = (cell.folder / ".git/hooks/pre-commit").read_text()
    assert hook == "#!/bin/sh\nexec tracerisk check\n"


def test_in_a_package_below_the_top_hook_and_ci_go_where_git_and_its_tools_look(cell):
    (cell.folder / "ws/pick").mkdir(parents=True)
    package = type(cell)(cell.folder / "ws/pick")
    package.write("package.xml", "<package><name>pick</name></package>")
    package.write("scripts/pick.py", cell.read("src/pick.py"))
    outcome = package.run("init", "--robot", "panda", "--yes", "--ci", "github")
    said = " ".join(outcome.out.split())
    assert "../../.pre-commit-config.yaml: the hook" in said
    assert (cell.folder / ".pre-commit-config.yaml").is_file()
    assert (cell.folder / ".github/workflows/risk.yml").is_file()
    assert (package.folder / "hardware.yaml").is_file()
    command = re.search(r"this is the hook: (printf .*)", outcome.out)[1]
    subprocess.run(command, shell=True, cwd=package.folder, check=True)
    assert (cell.folder / ".git/hooks/pre-commit").is_file()
    # Commands are for the shell in which it was called.
    (cell.folder / ".pre-commit-config.yaml").unlink()
    said = cell.run("init", "ws/pick", "--yes").out
    assert "`tracerisk run ws/pick/scripts/pick.py`" in said
    assert "> .git/hooks/pre-commit" in said


@pytest.mark.parametrize(
    ("scenarios", "expected"),
    [
        (["cell"], 'scenario = "cell.scenario.yaml"\n# The'),
        (["pick"], 'scenario = "pick.scenario.yaml"\n# The'),
        (["cell", "other"], None),
        (
            ["cell", "pick"],
            '\n[tool.tracerisk.controllers."src/pick.py"]\nscenario = "pick.scenario.yaml"\n',
        ),
    ],
)
def test_the_scenario_that_is_there_is_a_setting(cell, scenarios, expected):
    for name in scenarios:
        cell.write(f"{name}.scenario.yaml", "start: {}\n")
    cell.run("init", "--yes")
    text = cell.read("pyproject.toml").decode()
    assert (expected in text) if expected else ("scenario" not in text)
    used = cell.run("doctor", "src/pick.py", "--json").json["settings"]["scenario"]["value"]
    assert (used is None) == (expected is None)
    assert used is None or Path(used).name in expected


def test_it_says_how_the_hook_comes_to_work(cell):
    wanted = "Next: `pip install pre-commit`, then `pre-commit install`"
    assert wanted not in cell.run("init").out
    said = cell.run("init", "--yes").out
    assert wanted in said
    assert f"where it is on PATH, here after `source {sys.prefix}/bin/activate`." in said
    assert wanted not in cell.run("init", "--yes").out


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ci", ["github", "gitlab"])
def test_what_it_writes_is_enough_for_a_first_figure(cell, ci):
    assert cell.run("init", "--yes", "--ci", ci).code == 0
    written = files(cell)
    place = {"github": ".github/workflows/risk.yml", "gitlab": "tracerisk.gitlab-ci.yml"}[ci]
    for name in (".pre-commit-config.yaml", place):
        assert "tracerisk check" in written[name].decode()
    if ci == "github":
        workflow = YAML(typ="safe").load(written[place])
        assert workflow["permissions"]["pull-requests"] == "write", "for the comment"
        action = YAML(typ="safe").load((SAMPLES.parent / "action.yml").read_text())
        used = workflow["jobs"]["risk"]["steps"][-1]
        assert used["uses"].partition("@")[0].endswith("/tracerisk")
        assert set(used["with"]) <= set(action["inputs"])
        assert action["inputs"]["comment"]["default"] == "true"
        assert YAML(typ="safe").load(written[name])
    assert b"merge=tracerisk-lock" in written[".gitattributes"]
    ran = cell.run("run", "src/pick.py")
    assert ran.code == 0, ran.err
    assert "mission of pick.py" in " ".join(ran.out.split())
    assert cell.run("check").code == 0
    again = cell.run("init", "--yes", "--ci", ci)
    assert again.code == 0
    assert "Everything is there already" in again.out
    after = files(cell)
    assert {name: after[name] for name in written if name != "src/pick.py"} == {
        name: written[name] for name in written if name != "src/pick.py"
    }


def test_the_job_of_gitlab_is_written_whole_and_included(cell):
    assert cell.run("init", "--yes", "--ci", "gitlab").code == 0
    own = YAML(typ="safe").load(cell.read(".gitlab-ci.yml"))
    assert own == {"include": {"local": "tracerisk.gitlab-ci.yml"}}
    job = YAML(typ="safe").load(cell.read("tracerisk.gitlab-ci.yml"))["tracerisk"]
    assert {"if": '$CI_PIPELINE_SOURCE == "merge_request_event"'} in job["rules"]
    shipped = YAML(typ="safe").load(template("gitlab.yaml"))["tracerisk"]
    assert job["variables"].keys() == shipped["variables"].keys()
    assert job["script"] == shipped["script"]


def test_jobs_of_gitlab_that_are_there_stay_and_are_told_to_include_ours(cell):
    mine = "build: {script: [make]}\n"
    cell.write(".gitlab-ci.yml", mine)
    outcome = cell.run("init", "--yes", "--ci", "gitlab")
    assert "add to .gitlab-ci.yml: include: {local: tracerisk.gitlab-ci.yml}" in outcome.out
    assert cell.read(".gitlab-ci.yml").decode() == mine
    assert cell.read("tracerisk.gitlab-ci.yml")


@pytest.mark.parametrize(
    ("urls", "version", "action", "package"),
    [
        (
            ["Source, https://github.com/cell/tracerisk"],
            "0.3.0",
            "cell/tracerisk@v0.3.0",
            "tracerisk[large]==0.3.0",
        ),
        (
            ["Source, https://github.com/cell/risk.git"],
            "0.3.1.dev2",
            "cell/risk@main",
            "tracerisk[large] @ git+https://github.com/cell/risk@main",
        ),
        (
            ["Issues, https://github.com/a/b/issues"],
            "0.3.0",
            "OWNER/tracerisk@v0.1.0",
            "tracerisk[large]==0.3.0",
        ),
        (
            ["Source, https://git.example/a/b"],
            "0.3.1.dev2",
            "OWNER/tracerisk@v0.1.0",
            "tracerisk[large]",
        ),
        (None, "0.3.0", "OWNER/tracerisk@v0.1.0", "tracerisk[large]==0.3.0"),
    ],
)
def test_ci_files_name_where_the_installed_package_came_from(
    monkeypatch, cell, urls, version, action, package
):
    class Metadata:
        def get_all(self, name):
            return urls

    monkeypatch.setattr(metadata, "metadata", lambda name: Metadata())
    monkeypatch.setattr(metadata, "version", lambda name: version)
    (workflow,) = ci_files(cell.folder, "github")
    assert f"uses: {action}\n" in workflow.content.decode()
    job, _ = ci_files(cell.folder, "gitlab")
    variables = YAML(typ="safe").load(job.content)["tracerisk"]["variables"]
    assert variables["TRACERISK_PACKAGE"] == package
    assert ("set TRACERISK_PACKAGE" in job.why) is (package == "tracerisk[large]")


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("typed", "code", "said"),
    [
        (b"\x04", 0, "Nothing was written; `tracerisk init --yes` writes it."),
        (b"\x03", 130, "tracerisk: interrupted"),
        (b"n\n", 0, "Nothing was written"),
        (b"y\n", 0, "pyproject.toml: written"),
    ],
    ids=["Ctrl-D", "Ctrl-C", "no", "yes"],
)
def test_what_is_typed_at_its_question_is_understood(cell, typed, code, said):
    before = files(cell)
    keyboard, terminal = pty.openpty()
    # A signal of the keyboard comes to those of the terminal's session alone.
    start = program(os.environ, is_afresh=typed == b"\x03", verb="init")
    command = [*start, "init", "--blocks", "published"]
    process = subprocess.Popen(
        ["setsid", "--ctty", "--wait", *command],
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
        cwd=cell.folder,
    )
    os.close(terminal)
    shown = b""
    try:
        while b"[y/N]" not in shown:
            shown += os.read(keyboard, 4096)
        os.write(keyboard, typed)
        for _ in range(3):
            while select.select([keyboard], [], [], 10.0)[0]:
                shown += os.read(keyboard, 4096)
            # Python waits on if an interrupt comes between its prompt and its read: press again.
            os.write(keyboard, typed)
    except OSError:  # nobody has the terminal open any more
        pass
    finally:
        os.close(keyboard)
    assert process.wait(timeout=60) == code, shown.decode()
    assert said in shown.decode()
    assert "Traceback" not in shown.decode()
    assert (files(cell) == before) is (typed != b"y\n")


def test_with_a_closed_standard_input_it_shows_and_writes_nothing(cell):
    before = files(cell)
    done = subprocess.run(
        ["/bin/sh", "-c", 'exec "$0" -m tracerisk init <&-', sys.executable],
        cwd=cell.folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Nothing was written" in done.stdout
    assert files(cell) == before


def test_the_schemas_that_its_files_refer_to_are_there(cell):
    assert cell.run("init", "--yes").code == 0
    for name, mark in (("hardware.yaml", "$schema="), ("pyproject.toml", "#:schema ")):
        first = cell.read(name).decode().splitlines()[0]
        schema = json.loads(cell.read(first.partition(mark)[2]))
        assert schema["$schema"] == "http://json-schema.org/draft-07/schema#", name
    (cell.folder / "src" / "package.xml").write_text("<package format='3'><name>c</name></package>")
    (cell.folder / "pyproject.toml").unlink()
    assert cell.run("init", "--yes").code == 0
    first = cell.read("src/pyproject.toml").decode().splitlines()[0]
    assert first == "#:schema ../pyproject.schema.json"


def test_files_that_are_there_stay(cell):
    mine = {
        "pyproject.toml": '[project]\r\nname = "cell"\r\nversion = "1"',
        ".pre-commit-config.yaml": "repos: []\n",
        "hardware.yaml": "components:\n  motor: {failure_rate: {value: 1e-6, per: hour}}\n",
    }
    for name, text in mine.items():
        (cell.folder / name).write_bytes(text.encode())
    assert cell.run("init", "--yes").code == 0
    after = files(cell)
    assert after[".pre-commit-config.yaml"].decode() == mine[".pre-commit-config.yaml"]
    assert after["hardware.yaml"].decode() == mine["hardware.yaml"]
    settings = after["pyproject.toml"].decode()
    assert settings.startswith(mine["pyproject.toml"] + "\r\n\r\n[tool.tracerisk]\r\n")
    assert 'hardware = "hardware.yaml"' in settings
    assert "\n" not in settings.replace("\r\n", "")


def test_settings_that_are_there_are_not_touched(cell):
    cell.write("pyproject.toml", "[tool.tracerisk]\nseed = 3\n")
    outcome = cell.run("init", "--yes")
    assert outcome.code == 0
    assert cell.read("pyproject.toml").decode() == "[tool.tracerisk]\nseed = 3\n"
    lack = (
        'pyproject.toml is kept as it is; add to [tool.tracerisk]: hardware = "hardware.yaml"; '
        "without it, no run reads hardware.yaml"
    )
    assert f"Next: {lack}\n" in outcome.out
    assert cell.run("init", "--json").json["lacking"] == [lack]
    cell.write("pyproject.toml", '[tool.tracerisk]\nhardware = "hardware.yaml"\n')
    assert "no run reads" not in cell.run("init", "--yes").out


def test_settings_that_are_there_lack_the_hardware_of_each_robot(cell):
    shutil.copy(SAMPLES / "surface_scan.py", cell.folder / "src" / "scan.py")
    own = '[tool.tracerisk]\n[tool.tracerisk.controllers."src/pick.py"]\nhardware = "mine.yaml"\n'
    cell.write("pyproject.toml", own)
    outcome = cell.run("init", "--yes")
    assert (
        'add to [tool.tracerisk.controllers."src/scan.py"]: hardware = "hardware_ur5e.yaml"; '
        "without it, no run reads hardware_ur5e.yaml\n"
    ) in outcome.out
    assert "hardware_panda.yaml" not in outcome.out.partition("Next:")[2]


@pytest.mark.slow
def test_a_description_that_no_settings_name_is_said_by_run_and_check(cell):
    cell.write("pyproject.toml", "[tool.tracerisk]\nseed = 3\n")
    assert cell.run("init", "--yes").code == 0
    said = (
        "hardware.yaml: no settings name it, so its figures count nowhere; add to [tool.tracerisk] "
        'in pyproject.toml: hardware = "hardware.yaml"'
    )
    assert said in cell.run("run", "src/pick.py").err
    checked = cell.run("check")
    assert checked.code == 0
    assert said in checked.err
    assert said in cell.run("refresh").err
    # A description of something else is none, and one that the options name is read.
    assert said not in cell.run("run", "src/pick.py", "--hardware", "hardware.yaml").err
    assert said not in cell.run("check").err
    cell.write("hardware.yaml", "ros2_control: {components: []}\n")
    assert said not in cell.run("run", "src/pick.py").err


def test_controllers_of_several_robots_have_a_description_each(cell):
    shutil.copy(SAMPLES / "surface_scan.py", cell.folder / "src" / "scan.py")
    outcome = cell.run("init", "--yes", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["robots"] == {"panda": ["src/pick.py"], "ur5e": ["src/scan.py"]}
    settings = cell.read("pyproject.toml").decode()
    assert '[tool.tracerisk.controllers."src/scan.py"]\nhardware = "hardware_ur5e.yaml"' in settings
    assert cell.run("hardware", "show", "hardware_ur5e.yaml").code == 0


def test_a_package_of_a_workspace_has_its_own_settings_and_they_count(cell):
    cell.write("src/package.xml", "<package format='3'><name>cell</name></package>")
    outcome = cell.run("init", "--yes")
    assert outcome.code == 0, outcome.err
    assert "src/pyproject.toml: settings of all controllers of src" in outcome.out
    assert not (cell.folder / "pyproject.toml").exists()
    assert 'hardware = "../hardware.yaml"' in cell.read("src/pyproject.toml").decode()
    assert "../hardware.yaml" in cell.run("doctor", "src/pick.py").out
    assert "Everything is there already" in cell.run("init").out


def test_a_robot_that_is_given_counts(cell):
    outcome = cell.run("init", "--robot", "ur5e", "--json")
    assert outcome.json["robots"] == {"ur5e": ["src/pick.py"]}
    assert outcome.json["written"] is False
    wrong = cell.run("init", "--robot", "ur55")
    assert wrong.code == 2
    assert "ur5" in wrong.err


UNNAMED = """\
import moveit_commander, rospy
rospy.init_node("x")
arm = moveit_commander.MoveGroupCommander("manipulator")
arm.go([0.1, -1.0, 1.0, 0.0, 0.5, 0.0], wait=True)
"""


def test_it_names_the_grippers_for_an_arm_whose_gripper_is_assumed(repository):
    repository.write("pick.py", UNNAMED + "hand = moveit_commander.MoveGroupCommander('gripper')\n")
    words = "the gripper of ur5e is assumed with all its figures; --robot ur5e+GRIPPER names it"
    assert words in " ".join(repository.run("init", "--robot", "ur5e").out.split())
    assert "assumed" not in repository.run("init", "--robot", "ur5e+robotiq_2f_85").out
    repository.write("pick.py", UNNAMED)
    assert "assumed" not in repository.run("init", "--robot", "ur5e").out


def test_a_robot_that_is_given_is_that_of_the_next_run(repository):
    repository.write("pick.py", UNNAMED)
    unknown = repository.run("init")
    assert "robot: unknown (pick.py names none that is known" in unknown.out
    hint = "Next: `tracerisk run pick.py"
    assert f"{hint} --robot NAME`" in repository.run("init", "--yes").out
    (repository.folder / "pyproject.toml").unlink()
    outcome = repository.run("init", "--yes", "--robot", "ur5e")
    assert outcome.code == 0, outcome.err
    assert f"{hint}`" in outcome.out
    settings = repository.read("pyproject.toml").decode()
    assert 'robot = "ur5e"\nhardware = "hardware.yaml"\n' in settings
    ran = repository.run("run", "pick.py")
    assert ran.code == 0, ran.err
    assert "on ur5e" in ran.err


def test_settings_that_are_there_and_name_no_robot_are_to_be_completed(repository):
    repository.write("pick.py", UNNAMED)
    assert repository.run("init", "--yes").code == 0
    outcome = repository.run("init", "--yes", "--robot", "ur5e")
    lack = 'add to [tool.tracerisk]: robot = "ur5e", hardware = "hardware.yaml"'
    assert f"pyproject.toml is kept as it is; {lack}" in outcome.out


def test_hardware_of_one_robot_is_not_that_of_a_controller_whose_robot_is_unknown(cell):
    cell.write("other/other.py", UNNAMED)
    assert cell.run("init", "--yes").code == 0
    settings = cell.read("pyproject.toml").decode()
    assert '[tool.tracerisk.controllers."src/pick.py"]\nhardware = "hardware.yaml"' in settings
    assert settings.count("hardware = ") == 1


def test_without_a_controller_or_git_it_still_helps(example):
    outcome = example.run("init", "--yes")
    assert outcome.code == 0, outcome.err
    assert "0 controllers found" in outcome.out
    assert "--robot NAME" in outcome.out
    assert (example.folder / "pyproject.toml").exists()
    assert example.run("init", "nothing").code == 2


def test_malformed_settings_are_reported_before_anything_is_written(cell):
    cell.write("pyproject.toml", "[tool.tracerisk\n")
    before = files(cell)
    outcome = cell.run("init", "--yes")
    assert outcome.code == 2
    assert "pyproject.toml" in outcome.err
    assert files(cell) == before


def test_what_a_controller_asks_its_cell_for_is_named_with_what_gives_it(cell):
    asks = (
        "import rospy\nfrom geometry_msgs.msg import PoseStamped\nimport moveit_commander\n"
        "from sensor_msgs.msg import JointState\nfrom std_srvs.srv import Trigger\n"
        "rospy.init_node('pick')\narm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "rospy.Subscriber('/part', PoseStamped, print)\n"
        "rospy.Subscriber('/joint_states', JointState, print)\n"
        "rospy.ServiceProxy('/clamp', Trigger)()\n"
    )
    cell.write("src/asks.py", asks)
    outcome = cell.run("init")
    assert outcome.code == 0, outcome.err
    told = "messages on /part (geometry_msgs/PoseStamped), service /clamp (std_srvs/Trigger)"
    assert f"src/asks.py asks its cell for {told}\n" in outcome.out
    assert "src/pick.py asks" not in outcome.out
    written = cell.run("init", "--yes").out
    assert "`tracerisk scenario src/asks.py --write`" in written
    assert cell.run("init", "--json").json["asked"] == {"src/asks.py": told.split(", ")}


def test_the_form_of_blocks_that_is_given_is_written_as_a_setting(cell):
    assert cell.run("init", "--yes", "--blocks", "compact").code == 0
    assert b'blocks = "compact"\n' in files(cell)["pyproject.toml"]
    again = cell.run("init", "--yes", "--blocks", "published")
    assert 'add to [tool.tracerisk]: blocks = "published"' in again.out
    kept = cell.run("init", "--yes")
    assert "add to [tool.tracerisk]" not in kept.out
    assert cell.run("run", "src/pick.py").code == 0
    assert b"# | act 1 -> done 1\n" in files(cell)["src/pick.py"]


def at_a_terminal(cell, monkeypatch, *answers):
    """Run `init` as for someone who types these answers; return the questions."""
    questions, left = [], list(answers)

    def typed(question):
        questions.append(question)
        if not left:
            raise EOFError
        return left.pop(0)

    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", typed)
    options = {"folder": str(cell.folder), "robot": None, "ci": "none", "blocks": None}
    assert init.run(Namespace(**options, yes=False, json=False, quiet=True)) == 0
    return questions


@pytest.mark.parametrize(("answer", "lines"), [("c", 1), ("", 0)])
def test_a_user_at_a_terminal_is_asked_for_the_form(cell, monkeypatch, answer, lines):
    first, second = at_a_terminal(cell, monkeypatch, answer, "y")
    assert "(published) or component (compact)?" in first
    assert "Write these files?" in second
    assert files(cell)["pyproject.toml"].count(b'blocks = "compact"') == lines


def test_the_end_of_input_is_a_no(cell, monkeypatch):
    before = files(cell)
    assert len(at_a_terminal(cell, monkeypatch)) == 2
    assert files(cell) == before


def test_a_clone_gets_the_merge_driver_that_no_commit_brings(cell):
    assert cell.run("init", "--yes").code == 0
    assert "Everything is there already" in cell.run("init").out
    cell.git("config", "--local", "--remove-section", "merge.tracerisk-lock")
    again = cell.run("init")
    assert ".git/config: by which git merges tracerisk.lock in this clone" in again.out
    assert "Everything is there already" not in again.out
    assert "git merges tracerisk.lock with tracerisk" in cell.run("init", "--yes").err
    assert "lock-merge" in cell.git("config", "--local", "merge.tracerisk-lock.driver")
    assert "Everything is there already" in cell.run("init").out


def test_the_settings_name_the_robot_where_no_simulator_can_find_it(cell, monkeypatch):
    from tracerisk.pipeline.start import project_start as starting

    monkeypatch.setattr(starting, "missing_extras", lambda: {"sim": "why"})
    start = starting.project_start(cell.folder)
    assert (start.robots, start.robot_why) == ({}, "the simulator is not installed")
    cell.write("pyproject.toml", '[tool.tracerisk]\nrobot = "xarm6"\n')
    start = starting.project_start(cell.folder)
    assert (start.robots, start.robot_why) == ({"xarm6": ("src/pick.py",)}, "")


def test_a_repository_with_a_lock_is_not_sent_to_its_first_run(cell):
    first = "read its verdict, commit blocks and tracerisk.lock"
    assert first in cell.run("init", "--yes").out
    cell.write("tracerisk.lock", '{"controllers": {}, "schema": "tracerisk.lock", "version": 2}\n')
    cell.write("pyproject.toml", "")
    again = cell.run("init", "--yes").out
    assert first not in again
    assert "`tracerisk refresh .` runs these again" in again
