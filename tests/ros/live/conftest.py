"""A live run needs rospy of ROS 1, which few machines have."""

import pytest

from tracerisk.errors import DependencyError


@pytest.fixture(scope="session")
def real_ros() -> str:
    """The Python that has rospy; skips the test where there is none."""
    from tracerisk.ros.live.real_ros import python_of_ros

    try:
        return python_of_ros()
    except DependencyError as error:
        pytest.skip(str(error))
