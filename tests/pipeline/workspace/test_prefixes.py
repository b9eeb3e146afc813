"""The prefixes of overlays and of the installed ROS, and the packages in them."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.installed_ros import MANIFEST, Prefix, write
from tracerisk.common.sandbox.process import passed_environment
from tracerisk.common.sandbox.ros_prefix import readable_folders, without_ros
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.config import Settings
from tracerisk.errors import InputError
from tracerisk.pipeline.workspace import prefixes
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.prefixes import (
    find_prefixes,
    installed_packages,
    python_folders,
    readable_of,
    with_interfaces,
)
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import workspace_of


@pytest.fixture(autouse=True)
def no_installed_ros(monkeypatch, tmp_path):
    """Have no test see the ROS of this machine."""
    monkeypatch.setattr(prefixes, "INSTALLED", tmp_path / "opt")


def found(root, ros=2, named=(), distro=None, **environment):
    return find_prefixes(root, root, ros, named, distro, environment)


def names(found_prefixes):
    return {Path(each.path).name: each.found_in for each in found_prefixes}


def test_prefixes_count_in_order_and_each_says_what_names_it(tmp_path):
    made = {name: Prefix(tmp_path / name) for name in ("chosen", "first", "second", "third")}
    for prefix in made.values():
        prefix.install("arm_msgs")
    system = Prefix(tmp_path / "opt/humble")
    system.install("arm_msgs")
    paths = {name: str(prefix.path) for name, prefix in made.items()}
    found_prefixes = found(
        tmp_path / "ws",
        named=(paths["chosen"],),
        AMENT_PREFIX_PATH=f"{paths['first']}:{paths['second']}:relative:",
        COLCON_PREFIX_PATH=paths["second"],
        CMAKE_PREFIX_PATH=f"{paths['third']}:/usr/local",
    )
    assert names(found_prefixes) == {
        "chosen": "the setting ros_prefixes",
        "first": "AMENT_PREFIX_PATH",
        "second": "AMENT_PREFIX_PATH",
        "third": "CMAKE_PREFIX_PATH",
        "humble": str(tmp_path / "opt"),
    }
    packages = installed_packages(found_prefixes)
    assert packages == {"arm_msgs": made["chosen"].path / "share/arm_msgs"}


@pytest.mark.parametrize(
    ("ros", "environment", "distro", "taken"),
    [
        (2, {}, None, "jazzy"),
        (2, {}, "humble", "humble"),
        (2, {"ROS_DISTRO": "humble"}, "jazzy", "humble"),
        (2, {"ROS_DISTRO": "noetic"}, None, "jazzy"),
        (1, {}, None, "noetic"),
        (1, {"CMAKE_PREFIX_PATH": "/usr/local"}, None, "noetic"),
    ],
)
def test_one_of_the_installed_distributions_of_its_ros_counts(
    tmp_path, ros, environment, distro, taken
):
    for name in ("humble", "jazzy"):
        Prefix(tmp_path / "opt" / name).install("arm")
    Prefix(tmp_path / "opt/noetic", ros=1).install("arm")
    assert [*names(found(tmp_path / "ws", ros, distro=distro, **environment))] == [taken]


def test_a_sourced_distribution_is_the_only_one(tmp_path):
    for name in ("humble", "jazzy"):
        Prefix(tmp_path / "opt" / name).install("arm")
    sourced = str(tmp_path / "opt/humble")
    assert names(found(tmp_path / "ws", AMENT_PREFIX_PATH=sourced)) == {
        "humble": "AMENT_PREFIX_PATH"
    }


def test_a_prefix_of_the_other_ros_does_not_count(tmp_path):
    one, two = Prefix(tmp_path / "one", ros=1), Prefix(tmp_path / "two")
    one.install("arm_one")
    two.install("arm_two")
    both = {"CMAKE_PREFIX_PATH": f"{one.path}:{two.path}"}
    assert list(installed_packages(found(tmp_path, 1, **both))) == ["arm_one"]
    assert list(installed_packages(found(tmp_path, 2, **both))) == ["arm_two"]


@pytest.mark.parametrize("layout", ["merged", "isolated"])
@pytest.mark.parametrize("sourced", [True, False])
def test_the_install_space_of_the_own_workspace_counts_sourced_or_not(tmp_path, layout, sourced):
    install = tmp_path / "ws/install"
    for name in ("arm_description", "arm_msgs"):
        prefix = Prefix(install if layout == "merged" else install / name)
        prefix.install(name)
    (install / "COLCON_IGNORE").touch()
    Prefix(tmp_path / "ws/build").install("half_built")
    own = tmp_path / "ws/src/pick"
    write(own, {"package.xml": MANIFEST.format(name="pick", needs="")})
    variables = {"COLCON_PREFIX_PATH": str(install)} if sourced else {}
    found_prefixes = find_prefixes(own, own, 2, environment=variables)
    assert list(installed_packages(found_prefixes)) == ["arm_description", "arm_msgs"]
    assert {each.found_in for each in found_prefixes} == {"the folder install of the workspace"}


def test_a_devel_space_has_the_packages_of_its_sources(tmp_path):
    sources = tmp_path / "other/src"
    write(sources, {"arm/package.xml": MANIFEST.format(name="arm_bringup", needs="")})
    devel = Prefix(tmp_path / "other/devel", ros=1)
    (devel.path / ".catkin").write_text(f"{sources};/not/here")
    (devel.path / "share/linked").symlink_to(sources / "arm")
    found_prefixes = found(tmp_path / "ws", 1, CMAKE_PREFIX_PATH=str(devel.path))
    packages = installed_packages(found_prefixes)
    assert packages["arm_bringup"] == sources / "arm"
    assert sources in readable_of(found_prefixes)


def test_ros_package_path_holds_sources_and_shares_of_ros_1_alone(tmp_path):
    write(
        tmp_path / "sources",
        {
            "deep/er/arm/package.xml": MANIFEST.format(name="arm_description", needs=""),
            "ignored/CATKIN_IGNORE": "",
            "ignored/package.xml": MANIFEST.format(name="ignored", needs=""),
            "build/package.xml": MANIFEST.format(name="built", needs=""),
        },
    )
    noetic = Prefix(tmp_path / "noetic", ros=1)
    noetic.install("arm_msgs")
    path = f"{tmp_path / 'sources'}:{noetic.path / 'share'}"
    packages = installed_packages(found(tmp_path / "ws", 1, ROS_PACKAGE_PATH=path))
    assert list(packages) == ["arm_description", "arm_msgs"]
    assert found(tmp_path / "ws", 2, ROS_PACKAGE_PATH=path) == ()


def test_the_own_workspace_goes_before_what_is_installed(tmp_path, monkeypatch):
    overlay = Prefix(tmp_path / "overlay")
    for name in ("arm_msgs", "pick"):
        overlay.install(name)
    own = tmp_path / "pick"
    write(own, {"package.xml": MANIFEST.format(name="pick", needs=""), "go.py": "import rclpy\n"})
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(overlay.path))
    workspace = workspace_of(load_controller(own / "go.py"), Settings())
    assert workspace.packages == Project(own).workspace().packages == {"pick": own}
    assert workspace.installed == {"arm_msgs": overlay.path / "share/arm_msgs"}
    assert workspace.findable == {"pick": own, **workspace.installed}


def test_the_setting_names_folders_from_the_file_that_gives_it(tmp_path):
    write(tmp_path, {"pyproject.toml": '[tool.tracerisk]\nros_prefixes = ["../underlay"]\n'})
    settings = ProjectSettings(tmp_path).of()
    assert settings.ros_prefixes == (str(tmp_path / "../underlay"),)
    assert settings.with_options({"sandbox": "require"}).ros_prefixes == ()


def test_python_modules_are_found_for_any_version_of_python_3(tmp_path):
    prefix = Prefix(tmp_path / "prefix")
    here = f"lib/python3.{sys.version_info.minor}/site-packages"
    folders = (
        "lib/python2.7/dist-packages",
        "lib/python3/dist-packages",
        "lib/python3.7/site-packages",
        "local/lib/python3.9/dist-packages",
        here,
    )
    for folder in folders:
        prefix.python({"arm/__init__.py": ""}, folder)
    found_prefixes = found(tmp_path, CMAKE_PREFIX_PATH="", AMENT_PREFIX_PATH=str(prefix.path))
    assert found_prefixes == ()  # nothing says that the folder is a prefix of ROS
    prefix.install("arm")
    found_prefixes = found(tmp_path, AMENT_PREFIX_PATH=str(prefix.path))
    order = [here, folders[1], folders[2], folders[3]]
    assert python_folders(found_prefixes) == tuple(prefix.path / each for each in order)


def test_a_package_that_is_installed_as_links_has_the_modules_of_its_sources(tmp_path):
    build = tmp_path / "ws/build/arm"
    write(build, {"arm/__init__.py": ""})
    prefix = Prefix(tmp_path / "ws/install/arm")
    prefix.install("arm")
    site = prefix.python({"arm.egg-link": f"{build}\n.", "gone.egg-link": "/not/here\n"})
    found_prefixes = found(tmp_path / "elsewhere", AMENT_PREFIX_PATH=str(prefix.path))
    assert python_folders(found_prefixes) == (Path(site), build)
    assert tmp_path / "ws/build" in readable_of(found_prefixes)


def test_a_sourced_shell_leaves_no_folder_of_ros_on_the_paths_of_a_process(tmp_path, monkeypatch):
    prefix = Prefix(tmp_path / "humble")
    prefix.install("arm")
    of_ros = [
        prefix.python({}, "lib/python3.10/site-packages"),
        prefix.python({}, "local/lib/python3.10/dist-packages"),
        str(prefix.path / "lib"),
        str(prefix.path / "opt/vendor/lib"),
    ]
    write(tmp_path / "ws/build/arm", {"colcon_build.rc": "0"})
    own = [str(tmp_path / "own"), str(tmp_path)]
    assert without_ros([*of_ros, str(tmp_path / "ws/build/arm"), *own]) == own
    monkeypatch.setenv("LD_LIBRARY_PATH", os.pathsep.join((of_ros[2], own[0])))
    assert passed_environment(Settings().limits.sandbox)["LD_LIBRARY_PATH"] == own[0]
    monkeypatch.setenv("LD_LIBRARY_PATH", of_ros[2])
    assert "LD_LIBRARY_PATH" not in passed_environment(Settings().limits.sandbox)


def test_the_environment_of_this_python_may_be_a_prefix_itself(tmp_path, monkeypatch):
    """An environment of conda is both; its own modules stay."""
    import sysconfig

    site = Path(sysconfig.get_path("purelib"))
    monkeypatch.setattr("tracerisk.common.sandbox.ros_prefix.is_prefix", lambda folder: True)
    assert without_ros([str(site)]) == [str(site)]
    prefix = Prefix(tmp_path / "environment")
    prefix.install("arm")
    monkeypatch.syspath_prepend(prefix.python({"arm/__init__.py": ""}))
    assert python_folders(found(tmp_path, AMENT_PREFIX_PATH=str(prefix.path))) == ()


def test_thousands_of_packages_are_indexed_in_a_second(tmp_path):
    prefix = Prefix(tmp_path / "huge")
    index = prefix.path / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    for number in range(3000):
        (index / f"package_{number}").touch()
    # What a walk through the packages would stumble over.
    for number in range(0, 3000, 10):
        (prefix.path / f"share/package_{number}/msg").mkdir(parents=True)
    began = time.process_time()
    packages = installed_packages(found(tmp_path, AMENT_PREFIX_PATH=str(prefix.path)))
    with_messages = with_interfaces(packages)
    folders = readable_folders(packages.values())
    assert time.process_time() - began < 1.0
    assert (len(packages), len(with_messages)) == (3000, 300)
    assert folders == (prefix.path,)


def test_nothing_leads_out_of_the_install_space_of_a_workspace(tmp_path):
    secret = tmp_path / "secret"
    write(secret, {"package.xml": MANIFEST.format(name="secret", needs="")})
    workspace = tmp_path / "ws"
    install = Prefix(workspace / "install")
    install.install("arm")
    install.install("leak")
    (install.path / "share/leak/package.xml").unlink()
    (install.path / "share/leak").rmdir()
    (install.path / "share/leak").symlink_to(secret)
    (install.path / "lib").mkdir()
    (install.path / "lib/python3.10").symlink_to(secret)
    devel = Prefix(workspace / "devel", ros=1)
    (devel.path / ".catkin").write_text(f"{secret};/")
    for ros, expected in ((2, ["arm"]), (1, [])):
        found_prefixes = found(workspace, ros)
        assert list(installed_packages(found_prefixes)) == expected
        assert python_folders(found_prefixes) == ()
        assert all(each.is_relative_to(workspace) for each in readable_of(found_prefixes))


def test_a_hostile_prefix_neither_blocks_nor_fills_memory(tmp_path):
    prefix = Prefix(tmp_path / "hostile", ros=1)
    share = prefix.path / "share"
    (prefix.path / ".catkin").unlink()
    os.mkfifo(prefix.path / ".catkin")
    prefix.install("good")
    (share / "circle").symlink_to(share / "circle")
    (share / "self").symlink_to(share)
    (share / "piped").mkdir()
    os.mkfifo(share / "piped/package.xml")
    sources = tmp_path / "sources"
    for name in ("pipe", "large", "bomb"):
        (sources / name).mkdir(parents=True)
    os.mkfifo(sources / "pipe/package.xml")
    with (sources / "large/package.xml").open("wb") as stream:
        stream.truncate(500 * 1024**2)
    bomb = '<!DOCTYPE a [<!ENTITY a "b">' + "".join(
        f'<!ENTITY a{n} "{"&a" + str(n - 1) + ";" if n else "&a;"}{"x" * 50}">' for n in range(20)
    )
    (sources / "bomb/package.xml").write_text(f"{bomb}]><package><name>&a19;</name></package>")
    path = f"{sources}:{share}"
    packages = installed_packages(found(tmp_path / "ws", 1, ROS_PACKAGE_PATH=path))
    assert list(packages) == ["bomb", "good", "large", "pipe"]
    assert with_interfaces(packages) == {}


@pytest.mark.parametrize(
    "value", ["", ":", "/not/here", "relative/folder", "\x01", "/dev/null", "/etc/passwd:/dev"]
)
def test_variables_that_name_nothing_give_no_prefix(tmp_path, value):
    variables = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "CMAKE_PREFIX_PATH", "ROS_PACKAGE_PATH")
    for ros in (1, 2):
        found_prefixes = found(tmp_path, ros, **dict.fromkeys(variables, value))
        assert installed_packages(found_prefixes) == {}


def test_the_tests_run_in_a_shell_with_a_sourced_ros(tmp_path):
    prefix = Prefix(tmp_path / "humble")
    prefix.install("arm")
    site = prefix.python({"yaml/__init__.py": "raise ImportError('of another Python')\n"})
    sourced = {"AMENT_PREFIX_PATH": str(prefix.path), "PYTHONPATH": site, "ROS_DISTRO": "humble"}
    code = "import tests.conftest, os, sys; print(os.environ.get('AMENT_PREFIX_PATH'), sys.path)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **sourced},
        cwd=Path(__file__).parents[3],
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    shown = done.stdout.decode()
    assert shown.startswith("None ")
    assert site not in shown


@pytest.mark.parametrize(
    "script",
    [
        "install/lib/python3.10/site-packages/app/move.py",
        "install/lib/app/move.py",
        "install/share/app/scripts/move.py",
    ],
)
def test_a_controller_that_is_installed_has_the_packages_beside_it(tmp_path, script):
    Prefix(tmp_path / "install").install("arm_msgs")
    write(tmp_path, {script: "import rclpy\n"})
    found_prefixes = found((tmp_path / script).parent)
    assert set(installed_packages(found_prefixes)) == {"arm_msgs"}
    assert found_prefixes[0].found_in == "the prefix in which the controller is installed"


def test_one_that_is_installed_apart_has_the_packages_that_are_beside_its_prefix(tmp_path):
    for name in ("app", "arm_msgs", "arm_lib"):
        Prefix(tmp_path / "install" / name).install(name)
    script = "install/app/lib/python3.10/site-packages/app/move.py"
    write(tmp_path, {script: "import rclpy\n"})
    found_prefixes = found((tmp_path / script).parent)
    assert set(installed_packages(found_prefixes)) == {"app", "arm_lib", "arm_msgs"}


RELAY = """\
#!/usr/bin/python3
# -*- coding: utf-8 -*-
# generated from catkin/cmake/template/script.py.in
# creates a relay to a python script source file, acting as that file.
# The purpose is that of a symlink
python_script = '/ws/src/app/scripts/move.py'
with open(python_script, 'r') as fh:
    exec(compile(fh.read(), python_script, 'exec'), {})
"""
ENTRY = """\
#!/usr/bin/python3
# EASY-INSTALL-ENTRY-SCRIPT: 'arm-app==0.0.1','console_scripts','move'
import re
import sys
"""


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (RELAY, "catkin wrote to start another one; name that one: /ws/src/app/scripts/move.py"),
        (ENTRY, "for the entry point 'move' of 'arm-app==0.0.1'; name the module"),
        (
            ENTRY.replace("ENTRY-SCRIPT", "SCRIPT"),
            "for the entry point 'move' of 'arm-app==0.0.1'",
        ),
    ],
    ids=["devel", "colcon", "older"],
)
def test_a_script_that_a_build_wrote_is_not_run_and_the_one_that_it_starts_is_named(
    tmp_path, text, says
):
    write(tmp_path, {"devel/lib/app/move.py": text})
    with pytest.raises(InputError, match=r"move\.py") as caught:
        load_controller(tmp_path / "devel/lib/app/move.py")
    assert says in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "import rospy\n",
        "# like generated from catkin/cmake/template/script.py.in\npython_script = 'a.py'\n",
        RELAY.replace("python_script =", "script ="),
    ],
)
def test_other_scripts_are_controllers(tmp_path, text):
    write(tmp_path, {"lib/app/move.py": text})
    assert load_controller(tmp_path / "lib/app/move.py").source == text.encode()


def _workspace(top, **more):
    """Write a workspace of two repositories, and return the package of the controller's."""
    own = "src/mine/pick"
    write(
        top,
        {
            "src/mine/.git/HEAD": "ref: refs/heads/main\n",
            f"{own}/package.xml": MANIFEST.format(name="pick", needs=""),
            f"{own}/pick/__init__.py": "",
            f"{own}/pick/go.py": "import rclpy\n",
            "src/maker/.git/HEAD": "ref: refs/heads/main\n",
            "src/maker/arm_description/package.xml": MANIFEST.format(
                name="arm_description", needs=""
            ),
            "src/maker/deep/arm_msgs/package.xml": MANIFEST.format(name="arm_msgs", needs=""),
            "src/maker/deep/arm_msgs/msg/Grip.msg": "float64 width\n",
            "src/single/package.xml": MANIFEST.format(name="arm_helpers", needs=""),
            "src/single/arm_helpers/__init__.py": "",
            "src/single/setup.py": "",
            "src/single/launch/arm.launch.py": "",
            **more,
        },
    )
    return top / own


@pytest.mark.parametrize("ros", [1, 2])
def test_packages_of_other_repositories_in_the_same_src_fill_in_what_is_absent(tmp_path, ros):
    own = _workspace(tmp_path)
    top = tmp_path / "src/mine"
    installed = Prefix(tmp_path / "prefix", ros=ros)
    installed.install("arm_description")
    path = {"CMAKE_PREFIX_PATH": str(installed.path)}
    found_prefixes = find_prefixes(own, top, ros, environment=path)
    packages = installed_packages(found_prefixes)
    assert packages == {
        "arm_description": installed.path / "share/arm_description",
        "arm_helpers": tmp_path / "src/single",
        "arm_msgs": tmp_path / "src/maker/deep/arm_msgs",
    }
    assert list(with_interfaces(packages)) == ["arm_msgs"]
    assert python_folders(found_prefixes) == (tmp_path / "src/single",)


@pytest.mark.parametrize("top", ["elsewhere/mine", "src/a/b/mine", "mine"])
def test_what_lies_beside_a_project_in_no_src_is_none_of_its_own(tmp_path, top):
    write(
        tmp_path,
        {
            f"{top}/package.xml": MANIFEST.format(name="pick", needs=""),
            f"{top}/../other/package.xml": MANIFEST.format(name="other", needs=""),
        },
    )
    assert find_prefixes(tmp_path / top, tmp_path / top, 2, environment={}) == ()


def test_a_group_of_repositories_in_src_has_what_is_beside_it_too(tmp_path):
    names_there = ("group/mine", "group/near", "far", "build/made", ".hidden")
    files = {}
    for each in names_there:
        manifest = MANIFEST.format(name=each.rpartition("/")[2].strip("."), needs="")
        files[f"src/{each}/package.xml"] = manifest
    write(tmp_path, files)
    mine = tmp_path / "src/group/mine"
    assert list(installed_packages(find_prefixes(mine, mine, 2, environment={}))) == ["far", "near"]
