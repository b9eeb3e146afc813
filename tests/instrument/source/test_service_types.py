"""The type of a service, read from the proxy that is made further down."""

import pytest

from tracerisk.errors import Location
from tracerisk.instrument.source.service_types import service_type

WAIT = "rospy.wait_for_service('detect')\n"


@pytest.mark.parametrize(
    ("source", "name", "found"),
    [
        (
            "from std_srvs.srv import Trigger\nrospy.ServiceProxy('/detect', Trigger)\n",
            "/detect",
            1,
        ),
        ("from std_srvs.srv import Trigger as T\nServiceProxy('detect', T)\n", "/cell/detect", 1),
        ("import std_srvs.srv\nServiceProxy('detect', std_srvs.srv.Trigger)\n", "/detect", 1),
        ("from std_srvs import srv\nServiceProxy('~detect', srv.Trigger)\n", "/pick/detect", 1),
        (
            "import std_srvs.srv as s\nServiceProxy(service_class=s.Trigger, name='detect')\n",
            "/detect",
            1,
        ),
        ("from std_srvs.srv import *\nServiceProxy('detect', Trigger)\n", "/detect", 1),
        (
            "from a.srv import *\nfrom b.srv import *\nServiceProxy('detect', Trigger)\n",
            "/detect",
            0,
        ),
        ("from std_srvs.srv import *\nServiceProxy('detect', kind.Trigger)\n", "/detect", 0),
        ("from std_srvs.srv import *\nServiceProxy('detect', kind)\n", "/detect", 0),
        ("from std_srvs.srv import Trigger\nServiceProxy('other', Trigger)\n", "/detect", 0),
        ("from std_srvs.srv import Trigger\nServiceProxy('detect', kind)\n", "/detect", 0),
        ("x = ServiceProxy('detect')\n", "/detect", 0),
    ],
)
def test_the_type_is_that_of_the_proxy(tmp_path, source, name, found):
    path = tmp_path / "c.py"
    path.write_text(WAIT + source)
    assert service_type(name, Location(str(path), 1)) == ("std_srvs/Trigger" if found else "")


def test_a_name_that_is_an_expression_is_compared_as_it_is_written(tmp_path):
    path = tmp_path / "c.py"
    path.write_text(
        "from std_srvs.srv import Empty, Trigger\n"
        "rospy.wait_for_service(self.names[0])\n"
        "ServiceProxy(self.names[1], Empty)\n"
        "ServiceProxy(self.names[0], Trigger)\n"
    )
    assert service_type("/detect", Location(str(path), 2)) == "std_srvs/Trigger"


def test_a_source_that_cannot_be_read_says_nothing(tmp_path):
    assert service_type("/detect", None) == ""
    assert service_type("/detect", Location(str(tmp_path / "gone.py"), 1)) == ""
