"""The shipped descriptions fit the messages that they speak of, in the ROS that they are for."""

from contextlib import suppress

import pytest

from tracerisk.errors import DriverError
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.driver_search import definitions_of, shipped_drivers
from tracerisk.ros.vendors.interface_checks import check_interface, types_in_use


@pytest.mark.parametrize("driver", shipped_drivers(), ids=lambda driver: driver.name)
def test_each_field_is_there_and_each_interface_is_of_a_known_type(driver):
    more = definitions_of(shipped_drivers())
    checked = set()
    for make in (Interfaces, Interfaces2):
        messages = TwinMessages(make(more=more))
        for each in driver.interfaces:
            for type_name in types_in_use(driver, each, messages):
                # What one name means may differ between the two.
                with suppress(DriverError):
                    check_interface(each, type_name, messages)
                    checked.add(each.name)
    assert checked == {each.name for each in driver.interfaces}
