"""What the probe notes of nodes of ROS 2 is told as nodes in Python tell it."""

from tracerisk.pipeline.run.live.compiled_ends import CompiledEnds


def end(what, name, space="", of="", node="/cell", pid=7, **more):
    return {"pid": pid, "made": what, "name": name, "node": node, "type": [space, of], **more}


def gone(what, name, node="/cell", pid=7):
    return {"pid": pid, "gone": what, "name": name, "node": node}


def test_topics_have_types_nodes_and_qualities():
    ends = [
        end("publisher", "/speed", "std_msgs::msg", "Float64", reliable=1, kept=1),
        end("subscription", "/joint_states", "sensor_msgs__msg", "JointState", reliable=0, kept=0),
    ]
    speed, states = CompiledEnds().frames(ends)
    assert speed == {
        "is": "publisher", "name": "/speed", "caller": "/cell", "type": "std_msgs/Float64",
        "quality": {"reliable": True, "latch": True},
    }  # fmt: skip
    assert states == {
        "is": "subscriber", "name": "/joint_states", "caller": "/cell",
        "type": "sensor_msgs/JointState", "takes_latched": False,
    }  # fmt: skip


def test_ends_of_one_topic_and_node_come_with_the_first_and_go_with_the_last():
    ends, made = CompiledEnds(), end("publisher", "/a", "p::msg", "T", reliable=1, kept=0)
    other = {**made, "node": "/other"}
    assert [frame["caller"] for frame in ends.frames([made, made, other])] == ["/cell", "/other"]
    assert list(ends.frames([gone("publisher", "/a")])) == []
    assert list(ends.frames([gone("publisher", "/a")])) == [
        {"is": "no_publisher", "name": "/a", "caller": "/cell"}
    ]
    (again,) = ends.frames([made])
    assert again["is"] == "publisher"


def test_what_a_process_had_is_gone_when_it_has_ended_without_giving_it_up():
    made = end("publisher", "/a", "p::msg", "T", reliable=1, kept=0)
    again = {**made, "pid": 8}
    left = {"is": "no_publisher", "name": "/a", "caller": "/cell"}
    ends = CompiledEnds()
    assert len(list(ends.frames([made, made]))) == 1
    assert ends.processes == {7}
    assert list(ends.without([7])) == [left]
    assert list(ends.without([7])) == []
    assert ends.processes == frozenset()
    # Started again, it comes and goes once.
    assert [frame["is"] for frame in ends.frames([again])] == ["publisher"]
    assert list(ends.frames([gone("publisher", "/a", pid=8)])) == [left]
    # The other way round: the new one is there before the old one has ended.
    assert len(list(ends.frames([made, again]))) == 1
    assert list(ends.without([7])) == []
    assert list(ends.frames([gone("publisher", "/a", pid=8)])) == [left]


def test_what_has_no_known_type_is_told_once_and_makes_no_frame():
    of = {"reliable": 1, "kept": 0}
    entries = [
        end("publisher", "/speed", **of),
        end("publisher", "/speed", **of),
        gone("publisher", "/speed"),
        end("client", "/hand/_action/send_goal"),
        end("client", "/hand/_action/get_result"),
    ]
    ends = CompiledEnds()
    assert list(ends.frames(entries)) == []
    assert ends.untyped == {"/speed": "/cell", "/hand": "/cell"}
    (frame,) = ends.frames([end("publisher", "/speed", "std_msgs::msg", "Float64", **of)])
    assert frame["is"] == "publisher"
    assert [frame["is"] for frame in ends.frames([gone("publisher", "/speed")])] == ["no_publisher"]


def test_an_action_is_known_by_the_service_for_its_goals():
    space, of = "control_msgs::action", "GripperCommand"
    ends = [
        end("client", "/hand/_action/send_goal", space, f"{of}_SendGoal"),
        end("client", "/hand/_action/get_result", space, f"{of}_GetResult"),
        end("client", "/hand/_action/cancel_goal", "action_msgs::srv", "CancelGoal"),
        end("subscription", "/hand/_action/feedback", space, f"{of}_FeedbackMessage", kept=0),
        gone("subscription", "/hand/_action/feedback"),
        end("service", "/own/_action/send_goal", space, f"{of}_SendGoal"),
    ]
    assert list(CompiledEnds().frames(ends)) == [
        {"is": "action_client", "name": "/hand", "type": f"control_msgs/{of}", "caller": "/cell"},
        {"is": "acts", "name": "/own"},
    ]


def test_services_are_asked_for_and_served():
    ends = [
        end("client", "/grip", "std_srvs::srv", "SetBool"),
        end("service", "/cell/stop", "std_srvs::srv", "Trigger"),
        gone("client", "/grip"),
    ]
    assert list(CompiledEnds().frames(ends)) == [
        {"is": "service_client", "name": "/grip", "type": "std_srvs/SetBool"},
        {"is": "serves", "name": "/cell/stop"},
    ]


def test_what_each_node_of_rclcpp_has_is_left_out():
    of = {"reliable": 1, "kept": 0}
    ends = [end("publisher", "/parameter_events", "rcl_interfaces::msg", "ParameterEvent", **of)]
    assert list(CompiledEnds().frames(ends)) == []
