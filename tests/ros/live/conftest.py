"""A live run needs rospy of ROS 1, or rclpy of ROS 2, which few machines have."""

from typing import Literal

import pytest

from tracerisk.errors import DependencyError


@pytest.fixture(scope="session")
def real_ros() -> str:
    """The Python that has rospy; skips the test where there is none."""
    return _python_of(1)


@pytest.fixture(scope="session")
def real_rclpy() -> str:
    """The Python that has rclpy, such as RCLPY_PYTHON names; skips where there is none."""
    return _python_of(2)


def _python_of(ros: Literal[1, 2]) -> str:
    from tracerisk.ros.live.real_ros import python_of_ros

    try:
        return python_of_ros(ros)
    except DependencyError as error:
        pytest.skip(str(error))
