"""dynamic_reconfigure: servers, clients, and the modules of `.cfg` files.

Source: ros/dynamic_reconfigure (commit 2654f22) `src/dynamic_reconfigure/*.py`, its tests, and
wiki.ros.org/dynamic_reconfigure/Tutorials.
"""

import sys

import pytest

from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver

CFG = """\
#!/usr/bin/env python
PACKAGE = "compliance"
from dynamic_reconfigure.parameter_generator_catkin import *

gen = ParameterGenerator()
gen.add("stiffness", double_t, 0b01, "of every axis [N/m]", 200.0, 0, 1000)
gen.add("name", str_t, 0b10, "of the set", "soft")
frame = gen.enum([gen.const("base", int_t, 0, ""), gen.const("tool", int_t, 1, "")], "frames")
gen.add("frame", int_t, 0b10, "of the axes", 0, 0, 1, edit_method=frame)
limits = gen.add_group("Limits")
limits.add("enabled", bool_t, 0b100, "whether limits hold", True)
exit(gen.generate(PACKAGE, "compliance", "Compliance"))
"""


@pytest.fixture
def run(scheduler, graph, tmp_path, monkeypatch):
    """Run a function as a program of ROS 1 beside a package with a `.cfg` file."""
    package = tmp_path / "compliance"
    for folder in ("cfg", "msg", "src/compliance"):
        (package / folder).mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>compliance</name></package>")
    (package / "cfg" / "Compliance.cfg").write_text(CFG)
    (package / "src" / "compliance" / "__init__.py").write_text("")

    def run_controller(main, *, has_messages=False):
        workspace = {}
        if has_messages:
            (package / "msg" / "Axis.msg").write_text("float64 stiffness\n")
            workspace["compliance"] = package
        else:
            monkeypatch.syspath_prepend(str(package / "src"))
        runtime = Runtime(scheduler, graph, argv=("controller.py",))
        with (
            activate(runtime),
            StandInFinder(Interfaces(workspace)),
            virtual_time(scheduler),
        ):
            try:
                return scheduler.run_main(main)
            finally:
                for name in [n for n in sys.modules if n.split(".")[0] == "compliance"]:
                    del sys.modules[name]

    return run_controller


def make_server(seen):
    import rospy
    from compliance.cfg import ComplianceConfig
    from dynamic_reconfigure.server import Server

    rospy.init_node("compliance")

    def changed(config, level):
        seen.append((config.stiffness, level))
        return config

    return Server(ComplianceConfig, changed)


@pytest.mark.parametrize("has_messages", [False, True])
def test_a_file_of_parameters_is_a_module(run, has_messages):
    def main():
        from compliance.cfg import ComplianceConfig as Config

        with pytest.raises(ImportError):
            from compliance.cfg import OtherConfig  # noqa: F401

        return (
            Config.defaults,
            (Config.min["stiffness"], Config.max["stiffness"], Config.max["frame"]),
            Config.all_level,
            [group["name"] for group in Config.config_description["groups"]],
            Config.Compliance_tool,
        )

    defaults, limits, level, groups, tool = run(main, has_messages=has_messages)
    assert defaults == {"stiffness": 200.0, "name": "soft", "frame": 0, "enabled": True}
    assert limits == (0.0, 1000.0, 1)
    assert (level, groups, tool) == (0b111, ["Limits"], 1)


def test_a_client_changes_what_a_server_holds_within_its_limits(run):
    def main():
        import rospy
        from dynamic_reconfigure import find_reconfigure_services
        from dynamic_reconfigure.client import Client

        seen, heard = [], []
        make_server(seen)
        client = Client("/compliance", timeout=2.0, config_callback=lambda c: heard.append(c.frame))
        assert client.get_configuration()["stiffness"] == 200.0
        assert [p["name"] for p in client.get_parameter_descriptions()] == [
            "stiffness", "name", "frame", "enabled",
        ]  # fmt: skip
        now = client.update_configuration({"stiffness": "2000", "frame": "tool"})
        client.update_configuration({"enabled": "no"})
        rospy.sleep(1.0)
        client.close()
        return (
            (now["stiffness"], now["frame"], now["groups"]["groups"]["Limits"]["enabled"]),
            seen,
            heard,
            rospy.get_param("/compliance/enabled"),
            find_reconfigure_services(),
        )

    now, seen, heard, enabled, servers = run(main)
    assert now == (1000.0, 1, True)
    assert seen == [(200.0, -1), (1000.0, 0b11), (1000.0, 0b100)]
    assert heard == [0, 1, 1]
    assert enabled is False
    assert servers == ["/compliance"]


def test_parameters_of_the_parameter_server_go_before_the_defaults(run):
    def main():
        import rospy

        rospy.set_param("/compliance/stiffness", 5000.0)
        return make_server([]).config["stiffness"], rospy.get_param("/compliance/stiffness")

    assert run(main) == (1000.0, 1000.0)


def test_what_a_server_cannot_take_is_an_error(run):
    def main():
        from dynamic_reconfigure import (
            DynamicReconfigureCallbackException,
            DynamicReconfigureParameterException,
        )
        from dynamic_reconfigure.client import Client

        server = make_server([])
        client = Client("/compliance")
        with pytest.raises(
            DynamicReconfigureParameterException, match="don't know parameter: mass"
        ):
            client.update_configuration({"mass": 1.0})
        with pytest.raises(DynamicReconfigureParameterException, match="can't set parameter"):
            client.update_configuration({"stiffness": "hard"})
        server.callback = lambda config, level: None
        with pytest.raises(DynamicReconfigureCallbackException, match="service call failed"):
            client.update_configuration({"stiffness": 1.0})
        with pytest.raises(DynamicReconfigureCallbackException, match="should return"):
            type(server)(server.type, server.callback, "other")

    run(main)


def test_a_server_that_is_not_there_is_named(run):
    def main():
        import rospy
        from dynamic_reconfigure.client import Client

        rospy.init_node("arm")
        with pytest.raises(rospy.ROSException):
            Client("/compliance", timeout=1.0)
        Client("/compliance")

    with pytest.raises(RunOver, match="service /compliance/set_parameters") as over:
        run(main)
    assert over.value.cause == "deadlock"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('gen.add("a b", int_t, 0, "")', "does not follow the ROS naming"),
        ('gen.add("a", int_t, 0, "", "x")', "'a' has type int, but default is 'x'"),
        ('gen.add("a", str_t, 0, "", "x", "a")', "Max or min specified for a"),
    ],
)
def test_a_malformed_description_is_reported(run, tmp_path, line, message):
    (tmp_path / "compliance" / "cfg" / "Compliance.cfg").write_text(
        CFG.split("gen.add(")[0] + line + "\n"
    )

    def main():
        from compliance.cfg import ComplianceConfig  # noqa: F401

    with pytest.raises(Exception, match=message):
        run(main)


def test_a_file_that_describes_nothing_is_reported(run, tmp_path):
    (tmp_path / "compliance" / "cfg" / "Compliance.cfg").write_text("x = 1\n")

    def main():
        from compliance.cfg import ComplianceConfig  # noqa: F401

    with pytest.raises(ImportError, match="it describes nothing"):
        run(main)
