"""What a compiled node that plans with MoveIt is to have done, in either ROS."""

from typing import Any


def assert_picked(trace: dict[str, Any]) -> None:
    """Assert that the functions of the author's picker commanded, in turn, and all arrived."""
    names = [command["function"]["name"] for command in trace["commands"]]
    assert names == [f"Picker::{name}" for name in ("home", "home", "approach", "lower", "grip")]
    assert {command["end"] for command in trace["commands"]} == {"arrived"}
    assert trace["verdict"]["kind"] == "complete"
