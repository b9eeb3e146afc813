"""rosgraph as a library.

Source: ros/ros_comm `tools/rosgraph/src/rosgraph/{__init__,masterapi,names,rosenv}.py`.
"""

import re

import pytest


def test_the_master_is_there_and_says_the_state_of_the_graph(run_node):
    def main():
        import rosgraph
        import rospy
        from std_msgs.msg import String

        rospy.init_node("arm")
        rospy.Publisher("talk", String, queue_size=1)
        assert rosgraph.is_master_online()
        master = rosgraph.Master("/arm")
        master.setParam("/speed", 0.5)
        assert master.getParam("/speed") == 0.5
        with pytest.raises(rosgraph.MasterError, match="is not set"):
            master.getParam("/nothing")
        publishers, _, _ = master.getSystemState()
        return ["/talk", ["/arm"]] in publishers, master.getTopicTypes(), master.master_uri

    published, types, uri = run_node(main)
    assert published
    assert ["/talk", "std_msgs/String"] in types
    assert uri == "http://localhost:11311"


def test_names_are_judged_joined_and_resolved(run_node):
    def main():
        from rosgraph import names

        assert names.is_legal_name("arm/joint_1")
        assert not names.is_legal_name("1st")
        return (
            names.ns_join("/cell", "arm"),
            names.canonicalize_name("//cell//arm"),
            names.resolve_name("~speed", "/cell/arm"),
            names.script_resolve_name("tool", "~speed"),
            names.script_resolve_name("tool", "speed"),
            names.get_ros_namespace(argv=["x", "__ns:=cell"]),
        )

    assert run_node(main) == (
        "/cell/arm", "/cell/arm", "/cell/arm/speed", "/tool/speed", "/speed", "/cell/",
    )  # fmt: skip


def test_the_command_line_says_where_the_master_is(run_node):
    def main():
        import rosgraph

        return rosgraph.get_master_uri(), rosgraph.myargv(["x", "a:=b", "c"])

    assert run_node(main, "__master:=http://cell:1") == ("http://cell:1", ["x", "c"])


def test_records_of_logging_are_written_as_ros_writes_them(run_node):
    def main():
        import io
        import logging

        from rosgraph.roslogging import RosStreamHandler

        out, err = io.StringIO(), io.StringIO()
        handler = RosStreamHandler(stdout=out, stderr=err)
        for level, text in ((logging.INFO, "ready"), (logging.CRITICAL, "lost")):
            handler.handle(
                logging.makeLogRecord(
                    {"levelname": logging.getLevelName(level), "levelno": level, "msg": text}
                )
            )
        return out.getvalue(), err.getvalue()

    out, err = run_node(main)
    assert re.fullmatch(r"\[INFO\] \[\d+\.\d{6}\]: ready\n", out)
    assert re.fullmatch(r"\[FATAL\] \[\d+\.\d{6}\]: lost\n", err)
