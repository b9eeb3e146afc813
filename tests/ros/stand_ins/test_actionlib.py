"""actionlib, as its sources and wiki document it.

Sources: ros/actionlib `src/actionlib/{action_client,simple_action_client,action_server,
simple_action_server,server_goal_handle}.py`, `test/{ref_server,ref_simple_server,
exercise_simple_client,simple_python_client_test}.py`, wiki actionlib/DetailedDescription.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver


@pytest.fixture
def run_node(run_node):
    """Shuts the node down after `main`, for a server keeps its process alive until then."""

    def run(main, *arguments):
        def then_shut_down():
            import rospy

            result = main()
            rospy.signal_shutdown("the test is over")
            return result

        return run_node(then_shut_down, *arguments)

    return run


def serve(execute=None, **options):
    """Serve /count: succeeds with goal + 1 unless told otherwise."""
    import actionlib
    from actionlib.msg import TestAction, TestResult

    def succeed(goal):
        server.set_succeeded(TestResult(goal.goal + 1), "counted")

    server = actionlib.SimpleActionServer(
        "count", TestAction, execute or (lambda goal: succeed(goal)), auto_start=False
    )
    server.start()
    return server


def make_client():
    import actionlib
    from actionlib.msg import TestAction

    return actionlib.SimpleActionClient("count", TestAction)


def test_a_goal_is_served_and_its_result_comes_back(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal
        from actionlib_msgs.msg import GoalStatus

        rospy.init_node("n")
        serve()
        client = make_client()
        assert client.wait_for_server()
        state = client.send_goal_and_wait(TestGoal(41))
        reported = GoalStatus.to_string(state), client.get_goal_status_text()
        return reported, client.get_result().result

    assert run_node(main) == (("SUCCEEDED", "counted"), 42)


def test_done_cb_has_run_before_wait_for_result_returns(run_node):
    def main():
        import rospy
        from actionlib.msg import TestFeedback, TestGoal

        rospy.init_node("n")
        log = []

        def execute(goal):
            rospy.sleep(1.0)
            server.publish_feedback(TestFeedback(7))
            rospy.sleep(1.0)
            server.set_succeeded()

        def done(state, result):
            rospy.sleep(0.5)
            log.append(("done", state, result.result))

        server = serve(execute)
        client = make_client()
        client.send_goal(
            TestGoal(1),
            done_cb=done,
            active_cb=lambda: log.append("active"),
            feedback_cb=lambda feedback: log.append(feedback.feedback),
        )
        assert client.simple_state == 0
        assert client.wait_for_result()
        log.append(round(rospy.get_time() % 1000, 2))
        return log

    log = run_node(main)
    assert log[:3] == ["active", 7, ("done", 3, 0)]


@pytest.mark.parametrize(("callback_s", "heard"), [(0.0, [0, 1, 2]), (0.15, [0, 1])])
def test_feedback_just_before_the_result_is_heard_unless_an_earlier_one_holds_it_up(
    run_node, callback_s, heard
):
    def main():
        import rospy
        from actionlib.msg import TestFeedback, TestGoal

        rospy.init_node("n")
        log = []

        def execute(goal):
            for number in range(3):
                rospy.sleep(0.1)
                server.publish_feedback(TestFeedback(number))
            server.set_succeeded()

        def hear(feedback):
            log.append(feedback.feedback)
            rospy.sleep(callback_s)

        server = serve(execute)
        client = make_client()
        client.send_goal(TestGoal(1), feedback_cb=hear)
        client.wait_for_result()
        return list(log)

    assert run_node(main) == heard


def test_a_zero_duration_waits_for_ever_and_another_for_its_time(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")

        def execute(goal):
            rospy.sleep(50.0)
            server.set_succeeded()

        server = serve(execute)
        client = make_client()
        client.send_goal(TestGoal(1))
        began = rospy.get_time()
        short = client.wait_for_result(rospy.Duration(2.0))
        after = rospy.get_time() - began
        return short, round(after, 1), client.wait_for_result(rospy.Duration(0))

    assert run_node(main) == (False, 2.0, True)


@pytest.mark.parametrize("wait", ["wait_for_server", "wait_for_result"])
def test_a_timeout_that_is_no_duration_is_a_type_error(run_node, wait):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        serve()
        client = make_client()
        client.send_goal(TestGoal(1))
        with pytest.raises(TypeError):
            getattr(client, wait)(5.0)

    run_node(main)


def test_a_new_goal_preempts_the_one_before(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        log = []

        def execute(goal):
            for _ in range(100):
                if server.is_preempt_requested():
                    log.append(("preempted", goal.goal))
                    server.set_preempted()
                    return
                rospy.sleep(0.1)
            log.append(("reached", goal.goal))
            server.set_succeeded()

        server = serve(execute)
        first, second = make_client(), make_client()
        first.send_goal(TestGoal(1))
        rospy.sleep(1.0)
        second.send_goal(TestGoal(2))
        first.wait_for_result()
        second.wait_for_result()
        return log, first.get_state(), second.get_state()

    assert run_node(main) == ([("preempted", 1), ("reached", 2)], 2, 3)


def test_a_second_goal_of_a_client_silences_the_first(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        log = []
        server = serve(lambda goal: (rospy.sleep(1.0), server.set_succeeded()))
        client = make_client()
        client.send_goal(TestGoal(1), done_cb=lambda *_: log.append(1))
        rospy.sleep(0.5)
        client.send_goal(TestGoal(2), done_cb=lambda *_: log.append(2))
        client.wait_for_result()
        return log

    assert run_node(main) == [2]


def test_cancelling_reaches_the_server_and_the_state_says_so(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")

        def execute(goal):
            while not server.is_preempt_requested():
                rospy.sleep(0.1)
            states.append(client.get_state())
            rospy.sleep(0.1)
            server.set_preempted(text="as you wish")

        states = []
        server = serve(execute)
        client = make_client()
        client.send_goal(TestGoal(1))
        rospy.sleep(1.0)
        client.cancel_goal()
        client.wait_for_result()
        return states, client.get_state(), client.get_goal_status_text()

    # A goal that is being preempted is told as ACTIVE.
    assert run_node(main) == ([1], 2, "as you wish")


def test_send_goal_and_wait_cancels_after_its_timeout(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")

        def execute(goal):
            while not server.is_preempt_requested():
                rospy.sleep(0.1)
            server.set_preempted()

        server = serve(execute)
        return make_client().send_goal_and_wait(
            TestGoal(1), rospy.Duration(2.0), rospy.Duration(1.0)
        )

    assert run_node(main) == 2


def test_an_execute_callback_without_an_end_or_with_an_error_aborts(run_node, capsys):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")

        def execute(goal):
            if goal.goal == 2:
                raise ValueError("no such thing")

        serve(execute)
        client = make_client()
        reported = []
        for number in (1, 2):
            reported.append(client.send_goal_and_wait(TestGoal(number)))
            reported.append(client.get_goal_status_text())
        return reported

    assert run_node(main) == [
        4,
        "No terminal state was set.",
        4,
        "Exception in execute callback: no such thing",
    ]


def test_an_action_server_rejects_and_its_client_sees_every_state(run_node):
    def main():
        import actionlib
        import rospy
        from actionlib.msg import TestAction, TestGoal

        rospy.init_node("n")

        def take(handle):
            if handle.get_goal().goal < 0:
                handle.set_rejected(text="negative")
            else:
                handle.set_accepted()
                handle.set_succeeded()

        server = actionlib.ActionServer("count", TestAction, take, auto_start=False)
        server.start()
        client = actionlib.ActionClient("count", TestAction)
        client.wait_for_server()
        seen = {}
        for number in (-1, 1):
            seen[number] = []
            client.send_goal(
                TestGoal(number),
                lambda handle, number=number: seen[number].append(
                    actionlib.CommState.to_string(handle.get_comm_state())
                ),
            )
        rospy.sleep(1.0)
        return seen

    assert run_node(main) == {
        -1: ["PENDING", "WAITING_FOR_RESULT", "DONE"],
        1: ["ACTIVE", "WAITING_FOR_RESULT", "DONE"],
    }


def test_polling_the_state_ends(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal
        from actionlib_msgs.msg import GoalStatus

        rospy.init_node("n")
        server = serve(lambda goal: (rospy.sleep(1.0), server.set_succeeded()))
        client = make_client()
        client.send_goal(TestGoal(1))
        while client.get_state() != GoalStatus.SUCCEEDED:
            pass
        return client.get_state()

    assert run_node(main) == 3


def test_without_a_goal_the_client_says_so(run_node, capsys):
    def main():
        import rospy

        rospy.init_node("n")
        client = make_client()
        return client.get_state(), client.wait_for_result(), client.get_result()

    assert run_node(main) == (9, False, None)
    assert "Called wait_for_result when no goal exists" in capsys.readouterr().err


def test_a_server_that_never_comes_is_named(run_node):
    def main():
        import rospy

        rospy.init_node("n")
        make_client().wait_for_server()

    with pytest.raises(RunOver, match=r"action server /count \(actionlib/Test\)"):
        run_node(main)


def test_the_result_of_a_goal_that_nobody_serves_is_named(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        client = make_client()
        client.send_goal(TestGoal(1))
        client.wait_for_result()

    with pytest.raises(RunOver, match=r"the result of action /count \(actionlib/Test\)"):
        run_node(main)


def test_a_goal_that_is_none_and_a_type_that_is_no_action_are_refused(run_node):
    def main():
        import actionlib
        import rospy
        from actionlib.msg import TestGoal
        from std_msgs.msg import String

        rospy.init_node("n")
        with pytest.raises(actionlib.ActionException, match="not an action spec"):
            actionlib.SimpleActionClient("count", TestGoal)
        with pytest.raises(rospy.ROSSerializationException, match="goal must be of type"):
            make_client().send_goal(String("there"))

    run_node(main)


def test_a_callback_that_raises_is_logged(run_node, capsys):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        serve()
        client = make_client()

        def done(state, result):
            raise ValueError("oops")

        client.send_goal(TestGoal(1), done_cb=done)
        return client.wait_for_result(rospy.Duration(3.0))

    assert run_node(main) is False
    assert "ValueError: oops" in capsys.readouterr().err


def test_the_next_goal_can_be_sent_from_the_done_callback(run_node):
    def main():
        import rospy
        from actionlib.msg import TestGoal

        rospy.init_node("n")
        serve()
        client = make_client()
        seen = []

        def done(state, result):
            seen.append(result.result)
            if result.result < 3:
                client.send_goal(TestGoal(result.result), done_cb=done)

        client.send_goal(TestGoal(0), done_cb=done)
        rospy.sleep(1.0)
        return seen

    assert run_node(main) == [1, 2, 3]


def test_the_topics_of_actions_are_published_by_client_and_server(run_node):
    def main():
        import rospy

        rospy.init_node("n")
        make_client()
        asked = rospy.get_published_topics()
        serve()
        return asked, [name for name, _ in rospy.get_published_topics("/count")]

    asked, both = run_node(main)
    goal, cancel = ["/count/goal", "actionlib/TestActionGoal"], "actionlib_msgs/GoalID"
    assert asked == [["/count/cancel", cancel], goal]
    assert both == [f"/count/{leaf}" for leaf in ("cancel", "feedback", "goal", "result", "status")]


def test_the_status_of_a_goal_begins_with_its_identifier_or_with_a_new_one(run_node):
    def main():
        import rospy
        from actionlib.status_tracker import StatusTracker
        from actionlib_msgs.msg import GoalID, GoalStatus
        from control_msgs.msg import FollowJointTrajectoryActionGoal

        rospy.init_node("server")
        given = StatusTracker(GoalID(id="one"), GoalStatus.ACTIVE)
        made = StatusTracker(goal=FollowJointTrajectoryActionGoal())
        return given.status, made.status

    given, made = run_node(main)
    assert (given.goal_id.id, given.status) == ("one", 1)
    assert made.status == 0
    assert made.goal_id.id.startswith("/server-1-")
    assert made.goal_id.stamp.to_sec() > 0.0


@pytest.mark.parametrize("executes", [True, False])
def test_a_server_that_executes_keeps_its_process_alive(scheduler, graph, executes):
    """As seen with actionlib 1.14 on rospy: `main` returns, and the process lives on."""
    from tracerisk.ros.graph.runtime import Runtime, activate
    from tracerisk.ros.imports.finder import StandInFinder
    from tracerisk.ros.time.patches import virtual_time

    def main():
        import actionlib
        import rospy
        from actionlib.msg import TestAction

        rospy.init_node("server")
        execute = (lambda goal: None) if executes else None
        actionlib.SimpleActionServer("count", TestAction, execute, auto_start=False).start()

    with activate(Runtime(scheduler, graph, argv=("c.py",))), StandInFinder():  # noqa: SIM117
        with virtual_time(scheduler):
            if executes:
                with pytest.raises(RunOver, match="the end of thread action count") as over:
                    scheduler.run_main(main)
                assert over.value.cause == "quiescent"
            else:
                scheduler.run_main(main)


def test_a_handle_keeps_the_message_as_it_came_around_the_goal(run_node):
    def main():
        import actionlib
        import rospy
        from actionlib.msg import TestAction, TestGoal

        rospy.init_node("n")
        seen = []

        def take(handle):
            handle.set_accepted()
            stamp = handle.goal.header.stamp
            seen.append((handle.goal.goal.goal, handle.goal.goal_id == handle.get_goal_id()))
            seen.append((handle.get_goal().goal, stamp == handle.get_goal_id().stamp))
            handle.set_succeeded()

        actionlib.ActionServer("count", TestAction, take, auto_start=False).start()
        client = actionlib.SimpleActionClient("count", TestAction)
        client.wait_for_server()
        client.send_goal_and_wait(TestGoal(3))
        return seen

    assert run_node(main) == [(3, True), (3, True)]
