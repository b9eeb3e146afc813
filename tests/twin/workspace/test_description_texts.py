"""Which of a workspace's xacro files are expanded."""

import pytest

from tracerisk.common.limits import DEFAULT_LIMITS
from tracerisk.errors import RobotError
from tracerisk.twin.workspace.description_files import DescriptionFile
from tracerisk.twin.workspace.description_texts import DescriptionTexts

XACRO = (
    '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">{}<link name="base"/></robot>'
)
PART = XACRO.format('<xacro:arg name="side"/><link name="$(arg side)_hand"/>')


def test_parts_that_cannot_be_expanded_do_not_hide_the_robot_behind_them(tmp_path, monkeypatch):
    monkeypatch.setattr("tracerisk.twin.workspace.description_texts._MOST_EXPANDED", 1)
    texts = DescriptionTexts({}, {}, DEFAULT_LIMITS)
    found = []
    for number, text in enumerate([PART] * 2 + [XACRO.format("")] * 2):
        path = tmp_path / f"part{number}.urdf.xacro"
        path.write_text(text)
        try:
            texts.of(DescriptionFile(path, path.name, path.read_bytes()))
            found.append("expanded")
        except RobotError as error:
            found.append(str(error).partition(":")[0])
    assert found[2:] == ["expanded", "skipped after 3 xacro files (1 expanded)"]
    assert "expanded" not in found[:2]
    assert not any(words.startswith("skipped") for words in found[:2])


@pytest.mark.parametrize(
    ("lower", "expanded"),
    [
        ("-${pi}", "-3.14"),
        ("${-pi/2}", "-1.57"),
        ("${radians(-90)}", "-1.57"),
        ("-1.5", "-1.5"),
    ],
)
def test_expressions_in_a_urdf_are_those_of_xacro(tmp_path, lower, expanded):
    path = tmp_path / "arm.urdf"
    path.write_text(XACRO.format(f'<joint name="a"><limit lower="{lower}"/></joint>'))
    text = DescriptionTexts({}, {}, DEFAULT_LIMITS).of(
        DescriptionFile(path, path.name, path.read_bytes())
    )
    assert f'lower="{expanded}'.encode() in text


CONSTANTS = '<xacro:include filename="$(find of_others)/calibration.xacro"/>'
TURNS = '<joint name="a" type="revolute"><origin xyz="{}"/></joint>'


@pytest.mark.parametrize(
    ("value", "expanded"),
    [
        ("${head_offset} 0 0", "0.0 0 0"),
        ("0 ${1 - dx} 0", "0 1.0 0"),
        ("0 0 ${dz + dz}", "0 0 0.0"),
    ],
)
def test_constants_of_an_absent_file_are_0_and_in_doubt(tmp_path, value, expanded):
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(XACRO.format(CONSTANTS + TURNS.format(value)))
    file = DescriptionFile(path, path.name, path.read_bytes())
    texts = DescriptionTexts({}, {}, DEFAULT_LIMITS)
    assert f'xyz="{expanded}"'.encode() in texts.of(file)
    assert texts.is_without_parts(file)


def test_a_constant_that_no_file_lacks_is_an_error(tmp_path):
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(XACRO.format(TURNS.format("${head_offset} 0 0")))
    with pytest.raises(RobotError, match="head_offset"):
        DescriptionTexts({}, {}, DEFAULT_LIMITS).of(
            DescriptionFile(path, path.name, path.read_bytes())
        )
