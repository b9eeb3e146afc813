"""What a compiled node that plans with MoveIt is to have done, in either ROS."""

from typing import Any


def assert_picked(trace: dict[str, Any]) -> None:
    """Assert that the functions of the author's picker commanded, in turn, and all arrived."""
    names = [command["function"]["name"] for command in trace["commands"]]
    steps = ("home", "home", "approach", "lower", "grip", "retreat")
    assert names == [f"Picker::{step}" for step in steps]
    assert {command["end"] for command in trace["commands"]} == {"arrived"}
    assert trace["verdict"]["kind"] == "complete"
