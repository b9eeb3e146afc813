"""smach and smach_ros: containers, data, preemption, and states of actions and services."""

import pytest


def test_a_machine_follows_outcomes_and_hands_data_on(run_node):
    def main():
        import smach

        seen = []

        class Count(smach.State):
            def __init__(self):
                super().__init__(["more", "enough"], ["n"], ["n"])

            def execute(self, ud):
                ud.n = ud.n + 1
                return "more" if ud.n < 3 else "enough"

        @smach.cb_interface(outcomes=["over"], input_keys=["total"])
        def reported(ud, word):
            seen.append((word, ud["total"]))
            return "over"

        machine = smach.StateMachine(["over"], output_keys=["count"])
        machine.userdata.count = 0
        with machine:
            smach.StateMachine.add(
                "COUNT", Count(), {"more": "COUNT", "enough": "TELL"}, {"n": "count"}
            )
            smach.StateMachine.add(
                "TELL", smach.CBState(reported, cb_args=["n is"]), remapping={"total": "count"}
            )
        machine.register_transition_cb(
            lambda ud, active, word: seen.append((word, *active)), ["at"]
        )
        parent = smach.UserData()
        assert machine.get_initial_states() == ["COUNT"]
        assert ("more", "COUNT", "COUNT") in machine.get_internal_edges()
        assert machine.execute(parent) == "over"
        assert parent.count == 3
        return seen

    assert run_node(main) == [("at", "COUNT"), ("at", "COUNT"), ("at", "TELL"), ("n is", 3)]


def test_what_is_put_together_wrongly_is_reported(run_node):
    def main():
        import smach

        class Done(smach.State):
            def __init__(self, result="done"):
                super().__init__(["done"])
                self.result = result

            def execute(self, ud):
                if self.result == "read":
                    return ud.secret
                return self.result

        machine = smach.StateMachine(["over"])
        with pytest.raises(smach.InvalidStateError, match="no container is open"):
            smach.StateMachine.add("A", Done())
        with pytest.raises(smach.InvalidTransitionError, match="none of its outcomes"), machine:
            smach.StateMachine.add("A", Done(), {"gone": "over"})
        with pytest.raises(smach.InvalidTransitionError, match="leads to 'done'"), machine:
            smach.StateMachine.add("A", Done())
        with pytest.raises(smach.InvalidStateError, match="has a state 'A' already"), machine:
            smach.StateMachine.add("A", Done())
        with pytest.raises(smach.InvalidStateError, match="a int, and no smach"), machine:
            smach.StateMachine.add("B", 1)
        for result, reported in (
            ("else", "returned 'else'"),
            ("read", "none of the state's input_keys"),
        ):
            machine = smach.StateMachine(["over"])
            with machine:
                smach.StateMachine.add("A", Done(result), {"done": "over"})
            with pytest.raises(smach.InvalidUserCodeError, match=reported):
                machine.execute()
        machine = smach.StateMachine(["over"])
        with machine:
            smach.StateMachine.add("A", smach.CBState(lambda ud: 1 / 0, outcomes=["over"]))
        with pytest.raises(smach.InvalidUserCodeError, match="ZeroDivisionError"):
            machine.execute()

    run_node(main)


def test_concurrent_states_run_at_once_and_one_can_end_the_others(run_node):
    def main():
        import rospy
        import smach

        rospy.init_node("both")

        class Wait(smach.State):
            def __init__(self, seconds):
                super().__init__(["waited", "stopped"])
                self.seconds = seconds

            def execute(self, ud):
                end = rospy.get_time() + self.seconds
                while rospy.get_time() < end:
                    if self.preempt_requested():
                        self.service_preempt()
                        return "stopped"
                    rospy.sleep(0.1)
                return "waited"

        def both(child_termination_cb=None):
            found = smach.Concurrence(
                ["fine", "cut"],
                "cut",
                outcome_map={"fine": {"A": "waited", "B": "waited"}},
                child_termination_cb=child_termination_cb,
            )
            with found:
                smach.Concurrence.add("A", Wait(1.0))
                smach.Concurrence.add("B", Wait(3.0))
            return found

        began = rospy.get_time()
        assert both().execute() == "fine"
        middle = rospy.get_time()
        assert both(lambda outcomes: True).execute() == "cut"
        return round(middle - began, 1), round(rospy.get_time() - middle, 1)

    first, second = run_node(main)
    assert 3.0 <= first < 3.4
    assert 1.0 <= second < 1.4


def test_an_iterator_goes_through_its_items(run_node):
    def main():
        import smach

        seen = []
        each = smach.Iterator(["over"], [], [], it=lambda: range(4), it_label="n")
        with each:
            state = smach.CBState(
                lambda ud: seen.append(ud.n) or ("next" if ud.n < 2 else "enough"),
                outcomes=["next", "enough"],
                input_keys=["n"],
            )
            smach.Iterator.set_contained_state(
                "ONE", state, loop_outcomes=["next"], final_outcome_map={"enough": "over"}
            )
        return each.execute(), seen

    assert run_node(main) == ("over", [0, 1, 2])


def test_states_of_services_and_topics(run_node):
    def main():
        import rospy
        import smach
        from smach_ros import ConditionState, IntrospectionServer, MonitorState, ServiceState
        from std_msgs.msg import Int32
        from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

        rospy.init_node("calls")
        rospy.Service("switch", SetBool, lambda request: SetBoolResponse(request.data, "on"))
        topic = rospy.Publisher("n", Int32, queue_size=1)
        rospy.Timer(rospy.Duration(0.5), lambda event: topic.publish(5))
        machine = smach.StateMachine(["succeeded", "aborted"], output_keys=["message"])
        with machine:
            smach.StateMachine.add(
                "SWITCH",
                ServiceState(
                    "switch", SetBool, request=SetBoolRequest(True), response_slots=["message"]
                ),
                {"succeeded": "WATCH", "preempted": "aborted"},
            )
            smach.StateMachine.add(
                "WATCH",
                MonitorState("n", Int32, lambda ud, message: message.data < 5),
                {"invalid": "ASK", "valid": "aborted", "preempted": "aborted"},
            )
            smach.StateMachine.add(
                "ASK",
                ConditionState(lambda ud: rospy.get_time() > 0.0),
                {"true": "succeeded", "false": "aborted", "preempted": "aborted"},
            )
        view = IntrospectionServer("view", machine, "/JOB")
        view.start()
        data = smach.UserData()
        outcome = machine.execute(data)
        view.stop()
        return outcome, data.message

    assert run_node(main) == ("succeeded", "on")
