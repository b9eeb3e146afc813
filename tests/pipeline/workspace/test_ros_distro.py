"""The distribution of ROS is that of the settings, the workspace or the installed ROS."""

from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tracerisk.api import trace_controller
from tracerisk.config import Settings
from tracerisk.errors import SettingsError
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.ros_distro import choose_distro

PACKAGE = "<package format='3'><name>cell</name></package>"


@pytest.fixture
def chosen(tmp_path):
    """The choice for a script of ROS 2 in a package, beside given files."""

    def choose(files=(), *, script="import rclpy\n", environment=(), installed=(), **settings):
        (tmp_path / "package.xml").write_text(PACKAGE)
        (tmp_path / "arm.py").write_text(script)
        for name, text in dict(files).items():
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        for name in installed:
            (tmp_path / "installed" / name).mkdir(parents=True)
        controller = load_controller(tmp_path / "arm.py")
        place = tmp_path / "installed"
        return choose_distro(controller, Settings(**settings), dict(environment), place)

    return choose


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Dockerfile", "FROM ros:humble-ros-base\n"),
        ("docker/arm.Dockerfile", "FROM osrf/ros:humble-desktop\n"),
        (".devcontainer/Dockerfile", "FROM moveit/moveit2:humble-source\n"),
        (".devcontainer/devcontainer.json", '{"image": "ghcr.io/x/humble:latest"}\n'),
        (".github/workflows/ci.yml", "env:\n  ROS_DISTRO: humble\n"),
        (".github/workflows/ci.yml", "        required-ros-distributions: humble\n"),
        (".gitlab-ci.yml", "variables: {ROS_DISTRO: 'humble'}\n"),
        ("arm.repos", "  moveit2: {type: git, version: humble}\n"),
        ("arm.repos", "    version: humble-devel\n"),
        ("README.md", "Tested on Ubuntu 22.04 with ROS 2 Humble.\n"),
        ("README.md", "sudo apt install ros-humble-moveit\n"),
        ("README.rst", "source /opt/ros/humble/setup.bash\n"),
        ("setup.sh", "source /opt/ros/humble/setup.bash\n"),
        (".git/HEAD", "ref: refs/heads/humble-devel\n"),
    ],
)
def test_a_file_of_the_workspace_names_it(chosen, name, text):
    choice = chosen({name: text})
    assert (choice.name, choice.is_assumed) == ("humble", False)
    assert "branch" in choice.found_in or choice.found_in.startswith(f"{name}:")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("README.md", "A humble arm of iron that keeps rolling.\n"),
        ("Dockerfile", "# FROM ros:humble\nFROM ubuntu:22.04\n"),
        ("setup.sh", "echo humble beginnings\n"),
        ("notes.txt", "ROS 2 Humble\n"),
        ("build/Dockerfile", "FROM ros:humble\n"),
        ("README.md", "Ported from ROS Noetic.\n"),
    ],
)
def test_words_that_name_no_distribution_of_the_controllers_ros_are_not_taken(chosen, name, text):
    choice = chosen({name: text})
    assert (choice.name, choice.is_assumed) == ("jazzy", True)
    assert choice.assumption == "ros_distro: jazzy, nothing in the workspace names one"


def test_what_builds_the_workspace_weighs_more_than_what_its_readme_says(chosen):
    files = {"README.md": "Also runs on ROS 2 Jazzy.\n", "Dockerfile": "FROM ros:humble\n"}
    assert chosen(files).name == "humble"


@pytest.mark.parametrize("package", ["driver", "drivers/driver"])
def test_what_comes_with_another_package_counts_where_the_workspace_names_none(chosen, package):
    top = package.partition("/")[0]
    files = {
        f"{package}/package.xml": PACKAGE,
        f"{top}/docker/Dockerfile": "FROM ros:jazzy\n",
        f"{package}/README.md": "For ROS 2 Jazzy.\n",
    }
    assert (chosen(files).name, chosen(files).is_assumed) == ("jazzy", False)
    own = {"README.md": "Tested with ROS 2 Humble.\n"}
    choice = chosen(files | own)
    assert (choice.name, choice.is_assumed, choice.found_in) == ("humble", False, "README.md:1")
    # A folder without a package is the workspace's own.
    assert chosen(files | own | {"docker/Dockerfile": "FROM ros:jazzy\n"}).name == "jazzy"


def test_several_named_alike_are_an_assumption(chosen):
    choice = chosen({".github/workflows/ci.yml": "ros: [humble, jazzy]\n"})
    assert (choice.name, choice.is_assumed) == ("jazzy", True)
    assert choice.found_in == "named as often as humble: .github/workflows/ci.yml:1"


@pytest.mark.parametrize(
    ("written", "nearest"),
    [("foxy", "humble"), ("iron", "humble"), ("rolling", "jazzy"), ("kilted", "jazzy")],
)
def test_one_that_is_not_served_is_taken_as_the_nearest(chosen, written, nearest):
    choice = chosen({"Dockerfile": f"FROM ros:{written}\n"})
    assert (choice.name, choice.is_assumed) == (nearest, True)
    assert choice.found_in == f"the nearest that is served to {written}: Dockerfile:1"
    assert choice.follows_jazzy is (nearest == "jazzy")


@pytest.mark.parametrize("written", ["kinetic", "melodic"])
def test_an_older_one_of_ros_1_is_taken_as_noetic(chosen, written):
    choice = chosen({"Dockerfile": f"FROM ros:{written}\n"}, script="import rospy\n")
    assert (choice.name, choice.is_assumed) == ("noetic", True)


@pytest.mark.parametrize(
    ("image", "line", "is_older"),
    [
        ("", "print 'up'", True),
        ("", "print('up')", False),
        ("melodic", "print 'up'", True),
        ("melodic", "print('up')", True),
        ("melodic", "print(f'up {1}')", False),
        ("noetic", "print 'up'", False),
        ("noetic", "print('up')", False),
    ],
)
def test_what_noetic_cannot_run_or_an_older_one_is_named_for_precedes_it(
    chosen, image, line, is_older
):
    files = {"Dockerfile": f"FROM ros:{image}\n"} if image else {}
    choice = chosen(files, script=f"import rospy\n{line}\n")
    assert (choice.name, choice.precedes_noetic) == ("noetic", is_older)
    if not image and is_older:
        expected = "ros_distro: noetic, the nearest that is served to arm.py, which is Python 2"
        assert choice.assumption == expected
    assert not chosen(files, script=f"import rospy\n{line}\n", ros_distro="noetic").precedes_noetic


def test_the_installed_ros_decides_where_the_workspace_is_silent(chosen, tmp_path):
    choice = chosen(installed=["humble", "noetic"])
    assert (choice.name, choice.found_in) == ("humble", str(tmp_path / "installed" / "humble"))
    choice = chosen(environment={"ROS_DISTRO": "humble"})
    assert choice.found_in.startswith("the environment's ROS_DISTRO, ")
    assert chosen({"Dockerfile": "FROM ros:jazzy\n"}).name == "jazzy"


def test_the_settings_decide_first(chosen):
    choice = chosen({"Dockerfile": "FROM ros:jazzy\n"}, ros_distro="humble")
    assert (choice.name, choice.found_in) == ("humble", "by the settings")


def test_a_distribution_of_the_other_ros_is_refused_at_its_line(chosen, tmp_path):
    (tmp_path / "pyproject.toml").write_text('[tool.tracerisk]\nros_distro = "noetic"\n')
    with pytest.raises(
        SettingsError, match=r"noetic is not of ROS 2.*give humble or jazzy"
    ) as caught:
        chosen(ros_distro="noetic")
    assert (Path(caught.value.location.file).name, caught.value.location.line) == (
        "pyproject.toml",
        2,
    )


def test_the_build_tool_says_which_ros_where_the_script_does_not(chosen):
    script = "from std_msgs.msg import String\n"
    assert chosen(script=script).name == "noetic"
    built = "<package><export><build_type>ament_python</build_type></export></package>"
    assert chosen({"package.xml": built}, script=script).name == "jazzy"


def test_doctor_shows_it_with_its_place(example, quick):
    example.write("arm.py", "import rclpy\n\n" + quick("go()"))
    example.write("Dockerfile", "FROM ros:humble\n")
    outcome = example.run("doctor", "arm.py", "--json")
    assert outcome.json["found"]["ros_distro"] == "humble (Dockerfile:1)"


def test_an_unknown_one_is_an_error_of_the_settings(example, quick):
    example.write("arm.py", quick("go()"))
    example.write("pyproject.toml", '[tool.tracerisk]\nros_distro = "foxy"\n')
    outcome = example.run("doctor", "arm.py")
    assert "ros_distro: 'foxy' is not allowed; " in outcome.err


JUMP = "arm.compute_cartesian_path([arm.get_current_pose().pose], 0.01, 0.0)"


@pytest.mark.parametrize(
    ("release", "end", "codes"),
    [
        (None, "ended", ["distro-assumed"]),
        ("1.1.14", "ended", []),
        ("1.1.15", "raised", ["run-raised"]),
    ],
)
def test_the_settings_name_the_release_of_moveit(tmp_path, release, end, codes):
    (tmp_path / "a.py").write_text(quick_controller(JUMP))
    controller = load_controller(tmp_path / "a.py")
    given = {"moveit_release": release, "ros_distro": "noetic"}
    trace = trace_controller(controller, controller.settings_with(given))
    assert trace.end.cause == end
    found = [reason.code for reason in trace.verdict.reasons if reason.code != "never-ran"]
    assert found == codes


@pytest.mark.parametrize(
    ("words", "codes"),
    [("print 'planned'", []), ("print('planned')", ["distro-assumed"] * 4)],
)
def test_nothing_is_assumed_for_what_melodic_did_in_a_program_of_python_2(tmp_path, words, codes):
    steps = (
        "plan = arm.plan(arm.get_current_joint_values())",
        "arm.execute(plan)",
        "arm.execute(plan_msg=plan)",
        JUMP,
        words,
    )
    (tmp_path / "a.py").write_text(quick_controller(*steps))
    controller = load_controller(tmp_path / "a.py")
    trace = trace_controller(controller, controller.settings)
    assert trace.end.cause == "ended"
    found = [reason.code for reason in trace.verdict.reasons if reason.code != "never-ran"]
    assert found == codes


def test_a_release_of_moveit_has_three_numbers(tmp_path):
    (tmp_path / "a.py").write_text("")
    (tmp_path / "pyproject.toml").write_text('[tool.tracerisk]\nmoveit_release = "noetic"\n')
    with pytest.raises(SettingsError, match="expected a release as its package"):
        load_controller(tmp_path / "a.py").settings  # noqa: B018
