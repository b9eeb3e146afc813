"""Descriptions are tried in the order of what names them, and guesses never before these."""

from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.twin.robots.names_in_source import LaunchedBy, LaunchedDescription, Spoken
from tracerisk.twin.workspace.robot_of_workspace import find_workspace_robots

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
MODELS = ("ab1", "ab2", "ab3", "ab4")
ENDS = ("ab1", "ab4")
"""The first, within what is expanded of a kind, and the last, which lies behind it."""


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of each kind are expanded, so that each further one is too many."""
    monkeypatch.setattr("tracerisk.twin.workspace.description_texts._MOST_EXPANDED", 2)


def arm(name: str) -> str:
    """An arm of three joints whose names a macro makes; the second link has the robot's name."""
    joints = "".join(
        f'<xacro:turn n="{number}" parent="{parent}"/>'
        for number, parent in ((1, "base"), (2, "link1"), (3, f"{name}_elbow"))
    )
    return f"""\
<robot name="{name}" {XACRO}>
  <xacro:macro name="turn" params="n parent">
    <xacro:property name="child" value="${{'{name}_elbow' if n == 2 else 'link' + str(n)}}"/>
    <link name="${{child}}"/>
    <joint name="turn${{n}}" type="revolute"><parent link="${{parent}}"/><child link="${{child}}"/>
      <axis xyz="0 1 0"/><origin xyz="0 0 0.2"/>
      <limit lower="-2" upper="2" velocity="1" effort="9"/></joint>
  </xacro:macro>
  <link name="base"/>{joints}
</robot>"""


def srdf(name: str) -> str:
    return f"""\
<robot name="{name}" {XACRO}><xacro:property name="first" value="base"/>
  <group name="arm"><chain base_link="${{first}}" tip_link="link3"/></group>
</robot>"""


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def taken(
    top: Path, *strings: str, launched: tuple[LaunchedDescription, ...] = ()
) -> tuple[list[str], tuple[str, ...]]:
    """Return the elbows of the robots that are found, and what of the workspace is unreadable."""
    packages = {folder.name: folder for folder in top.iterdir() if folder.is_dir()}
    spoken = Spoken(strings, frozenset(), launched, (), strings)
    script = top / "demo" / "pick.py"
    found = find_workspace_robots((top,), packages, spoken, script)
    names = [name for one in found.described for name in one.robot.link_names]
    return [name for name in names if name.endswith("_elbow")], found.unreadable


def family(top: Path, *, with_srdf: bool = True) -> None:
    """A maker's package with a description, and maybe an SRDF, for each of its arms."""
    for name in MODELS:
        write(top / "descriptions" / f"{name}.urdf.xacro", arm(name))
        if with_srdf:
            write(top / "moveit" / f"{name}.srdf.xacro", srdf(name))
    (top / "demo").mkdir()


@pytest.mark.parametrize("name", slow_but(ENDS, MODELS))
def test_the_arm_that_the_source_names_is_read_after_the_srdf_files_of_all(tmp_path, name):
    family(tmp_path)
    found, unreadable = taken(tmp_path, name, "arm")
    assert found == [f"{name}_elbow"]
    assert not any(f"/{name}." in words for words in unreadable)


@pytest.mark.parametrize("name", slow_but(ENDS, MODELS))
def test_of_a_family_without_srdf_the_arm_that_the_source_names_is_read(tmp_path, name):
    family(tmp_path, with_srdf=False)
    assert taken(tmp_path, name) == ([f"{name}_elbow"], ())


def test_cameras_beside_the_arm_are_not_tried_before_it(tmp_path):
    """They lie nearer to the script, and say as many of its words."""
    for name in ("azure", "basler", "chameleon", "realsense"):
        macro = arm(name).replace("revolute", "fixed")
        write(tmp_path / "demo" / "cameras" / f"{name}.urdf.xacro", macro)
        write(tmp_path / "demo" / "cameras" / f"{name}.srdf.xacro", srdf(name))
    write(tmp_path / "far" / "support" / "urdf" / "sia5.urdf.xacro", arm("sia5"))
    found, _ = taken(tmp_path, "sia5", "base", "turn", "arm")
    assert found == ["sia5_elbow"]


@pytest.mark.parametrize("by", ["controller", "package", "named", "workspace"])
def test_the_arm_of_a_launch_file_is_read_after_those_that_nothing_names(tmp_path, by: LaunchedBy):
    family(tmp_path)
    path = tmp_path / "descriptions" / "ab4.urdf.xacro"
    launched = LaunchedDescription(path, (), "", "arm.launch", by)
    found, unreadable = taken(tmp_path, "arm", launched=(launched,))
    # Whose launch file it is decides whether it is taken; read it is in any case.
    assert not any("ab4.urdf.xacro: not looked at" in words for words in unreadable)
    assert by != "controller" or found == ["ab4_elbow"]


def test_the_urdf_of_the_srdfs_own_name_is_read_after_others_with_its_words(tmp_path):
    write(tmp_path / "moveit" / "config" / "cell.srdf", srdf("cell").replace("${first}", "base"))
    for name in ("aa", "ab", "ac"):
        write(tmp_path / "moveit" / "config" / f"{name}.urdf.xacro", arm(name))
    write(tmp_path / "urdf" / "cell.urdf.xacro", arm("cell"))
    (tmp_path / "demo").mkdir()
    found, _ = taken(tmp_path, "arm")
    assert found == ["cell_elbow"]
