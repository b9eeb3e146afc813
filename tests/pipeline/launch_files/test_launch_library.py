"""launch, as launch files use it: truth values, descriptions, conditions, arguments.

Sources: ros2/launch (branch rolling, commit 02595baf) `launch/launch/substitutions`, `conditions`,
`actions/include_launch_description.py`, `launch_description.py`.
"""

import pytest

from tracerisk.pipeline.launch_files.stand_ins.launch import LaunchContext, LaunchDescription
from tracerisk.pipeline.launch_files.stand_ins.launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    SetLaunchConfiguration,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.condition import Condition
from tracerisk.pipeline.launch_files.stand_ins.launch.conditions import (
    IfCondition,
    LaunchConfigurationEquals,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_source import (
    LaunchDescriptionSource,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_sources import (
    InvalidLaunchFileError,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.substitutions import (
    AllSubstitution,
    AnySubstitution,
    EqualsSubstitution,
    FileContent,
    IfElseSubstitution,
    NotSubstitution,
    PythonExpression,
    SubstitutionFailure,
    ThisLaunchFileDir,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import (
    normalize_to_list_of_substitutions,
    perform_substitutions,
)


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        (None, "", "true"),
        (True, "1", "true"),
        ("false", 0, "true"),
        (True, "10", "false"),
        ("true", "yes", "false"),
        (10, "10.0", "true"),
        ("nan", "nan", "false"),
        ("arm", "arm", "true"),
        ("arm", "Arm", "false"),
    ],
)
def test_two_values_are_equal_as_truth_values_numbers_or_texts(left, right, expected):
    assert EqualsSubstitution(left, right).perform(LaunchContext()) == expected
    assert EqualsSubstitution(right, left).perform(LaunchContext()) == expected


def test_truth_values_are_those_of_yaml_and_of_digits():
    context = LaunchContext()
    assert NotSubstitution("off").perform(context) == "true"
    assert AllSubstitution("on", "1", "True").perform(context) == "true"
    assert AnySubstitution("no", "0").perform(context) == "false"
    assert IfElseSubstitution("yes", else_value="b").perform(context) == ""
    with pytest.raises(SubstitutionFailure, match="'maybe' is no truth value"):
        NotSubstitution("maybe").perform(context)
    with pytest.raises(SubstitutionFailure, match="'maybe' is no truth value"):
        AnySubstitution("true", "maybe").perform(context)
    with pytest.raises(RuntimeError, match="One of if_value and else_value"):
        IfElseSubstitution("true")


def test_what_is_not_there_is_reported_by_the_substitution(tmp_path):
    context = LaunchContext()
    with pytest.raises(SubstitutionFailure, match="File not found"):
        FileContent(str(tmp_path / "none.txt")).perform(context)
    with pytest.raises(SubstitutionFailure, match="not within a launch file"):
        ThisLaunchFileDir().perform(context)
    with pytest.raises(TypeError, match="Failed to normalize"):
        normalize_to_list_of_substitutions(["arm", ["hand"]])
    assert PythonExpression(["1 + ", "2"]).describe() == "PythonExpr('1 + 2', ['math'])"
    error = InvalidLaunchFileError(extension=".py", likely_errors=[KeyError("arm")])
    assert "KeyError: 'arm'" in str(error)


def test_a_condition_without_a_predicate_does_not_hold_and_old_ones_warn():
    assert not Condition().evaluate(LaunchContext())
    assert Condition().describe() == "Condition"
    with pytest.warns(UserWarning, match="deprecated"):
        assert LaunchConfigurationEquals("arm", None).evaluate(LaunchContext())


def test_actions_keep_what_they_are_given_as_substitutions():
    context = LaunchContext()
    setting = SetLaunchConfiguration("arm", ["left", "_1"])
    reported = [setting.name, setting.value, LogInfo(msg=["a", "b"]).msg]
    assert [perform_substitutions(context, each) for each in reported] == ["arm", "left_1", "ab"]
    declared = DeclareLaunchArgument("arm", default_value="left", choices=["left", "right"])
    assert perform_substitutions(context, declared.default_value) == "left"
    assert "Valid choices are: ['left', 'right']" in declared.description


def test_a_description_lists_its_arguments_and_asks_for_those_that_are_missing():
    inner = LaunchDescription(
        [
            DeclareLaunchArgument("arm"),
            DeclareLaunchArgument("speed", default_value="1"),
            DeclareLaunchArgument("eye", condition=IfCondition("true")),
        ],
        deprecated_reason="use another",
    )
    include = IncludeLaunchDescription(LaunchDescriptionSource(inner, "<here>"))
    outer = LaunchDescription([GroupAction([]), include])
    listed = outer.get_launch_arguments()
    assert [each.name for each in listed] == ["arm", "speed", "eye"]
    assert [each._conditionally_included for each in listed] == [False, False, True]
    assert inner.deprecated
    with pytest.raises(RuntimeError, match=r"missing required argument 'arm' .* given: \[\]"):
        include.visit(LaunchContext())
    context = LaunchContext()
    given = IncludeLaunchDescription(
        LaunchDescriptionSource(inner, "<here>"), launch_arguments={"arm": "left"}
    )
    assert given.visit(context)[-1] is inner
    assert context.locals.current_launch_file_directory == "<here>"
    with pytest.raises(RuntimeError, match="no launch description"):
        LaunchDescriptionSource(location="nowhere.launch.py").get_launch_description(context)
