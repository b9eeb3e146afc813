"""Actions between clients and servers, whatever the version of ROS."""

import pytest

from tracerisk.ros.graph.action_goal import GoalState, GoalStateError
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.time.scheduler import RunOver
from tracerisk.twin.motion.execution import Motion

TYPE = "control_msgs/FollowJointTrajectory"


@pytest.fixture
def actions(scheduler, graph):
    return Runtime(scheduler, graph).client(Actions)


def serve(actions, taken, *, by_controller=True, type_name=TYPE):
    return actions.serve(
        "/arm",
        type_name,
        node="/server",
        on_goal=taken.append,
        on_cancel=lambda goal: goal.accept_cancel(),
        by_controller=by_controller,
    )


def test_a_goal_goes_through_its_states_and_its_client_is_reported_of_each(actions, run):
    taken, reported = [], []
    serve(actions, taken)
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        goal = client.send(
            "there",
            on_change=lambda goal: reported.append(goal.state.name),
            on_feedback=lambda goal, feedback: reported.append(feedback),
        )
        assert taken == [goal]
        goal.accept()
        goal.publish_feedback("halfway")
        goal.succeed("done", "all well")
        return goal

    goal = run(main)
    assert reported == ["ACTIVE", "halfway", "SUCCEEDED"]
    assert (goal.result, goal.text, goal.id) == ("done", "all well", "/client-1")
    assert goal.server.goals == []


@pytest.mark.parametrize(
    ("steps", "state"),
    [
        (("accept_cancel", "cancel"), GoalState.RECALLED),
        (("accept", "accept_cancel", "cancel"), GoalState.PREEMPTED),
        (("accept_cancel", "accept", "succeed"), GoalState.SUCCEEDED),
        (("accept_cancel", "reject"), GoalState.REJECTED),
        (("accept", "cancel"), GoalState.PREEMPTED),
        (("accept", "abort"), GoalState.ABORTED),
    ],
)
def test_where_the_steps_of_a_server_lead(actions, run, steps, state):
    taken = []
    serve(actions, taken)
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        goal = client.send("there")
        for step in steps:
            getattr(goal, step)()
        return goal.state

    assert run(main) is state


@pytest.mark.parametrize("step", ["accept", "succeed", "abort", "cancel", "reject", "execute"])
def test_a_goal_that_is_over_takes_no_further_step(actions, run, step):
    serve(actions, [])
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        goal = client.send("there")
        goal.reject("no")
        with pytest.raises(GoalStateError, match="goal of /arm that is REJECTED; the goal must be"):
            getattr(goal, step)()
        goal.ask_cancel()
        return goal.state

    assert run(main) is GoalState.REJECTED


@pytest.mark.parametrize("outcome", ["active", "aborted", "preempted"])
def test_a_goal_whose_motion_did_not_arrive_is_never_set_succeeded(actions, run, outcome):
    serve(actions, [])
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        goal = client.send("there")
        goal.accept()
        goal.motion = Motion(("joint1",), ("joint1",), 0, outcome=outcome)
        with pytest.raises(GoalStateError, match=f"whose motion is {outcome}; end it as"):
            goal.succeed("done")
        goal.motion.outcome = "succeeded"
        goal.succeed("done")
        return goal.state

    assert run(main) is GoalState.SUCCEEDED


def test_an_accepted_goal_is_executed_later(actions, run):
    serve(actions, [])
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        goal = client.send("there")
        goal.accept(executing=False)
        states = [goal.state.ros2_status]
        goal.execute()
        states.append(goal.state.ros2_status)
        goal.ask_cancel()
        return [*states, goal.state.ros2_status, goal.state.ros1_status]

    assert run(main) == [1, 2, 3, 6]


def test_all_goals_of_a_server_or_those_sent_until_a_time_are_cancelled(actions, run, scheduler):
    serve(actions, [])
    first = actions.client("/arm", TYPE, node="/first")
    second = actions.client("/arm", TYPE, node="/second")

    def main():
        early = first.send("there")
        scheduler.sleep(1_000_000_000)
        late = second.send("back")
        second.cancel_sent_until(early.sent_ns)
        asked = [early.is_cancel_asked, late.is_cancel_asked]
        first.cancel_all()
        return [*asked, late.is_cancel_asked]

    assert run(main) == [True, False, True]


def test_the_controllers_own_server_comes_before_the_twins(actions):
    twins = serve(actions, [], by_controller=False)
    client = actions.client("/arm", TYPE, node="/client")
    assert client.server is twins
    own = serve(actions, [])
    serve(actions, [], by_controller=False)
    assert client.server is own
    own.close()
    assert client.server is not None
    assert client.server.by_controller is False


def test_a_server_of_another_type_is_none(actions):
    serve(actions, [], type_name="control_msgs/GripperCommand")
    assert actions.client("/arm", TYPE, node="/client").server is None
    assert actions.names_and_types() == (("/arm", TYPE), ("/arm", "control_msgs/GripperCommand"))


def test_a_watcher_learns_of_what_comes_goes_and_was_there(actions):
    reported = []
    client = actions.client("/arm", TYPE, node="/client")
    actions.watch(lambda change, name, type_name: reported.append((change, name, type_name)))
    server = serve(actions, [])
    server.close()
    client.close()
    assert reported == [
        (change, "/arm", TYPE) for change in ("client", "served", "unserved", "client_gone")
    ]


def test_a_wait_for_a_server_ends_when_it_comes_or_after_the_timeout(actions, run, scheduler):
    client = actions.client("/arm", TYPE, node="/client")

    def main():
        waited = client.wait_for_server(500_000_000)
        scheduler.call_at(2_000_000_000, lambda: serve(actions, []))
        return waited, client.wait_for_server(), scheduler.now_ns

    assert run(main) == (False, True, 2_000_000_000)


def test_a_wait_for_a_server_that_never_comes_names_action_and_type(actions, run):
    client = actions.client("/arm", TYPE, node="/client")
    with pytest.raises(RunOver, match=r"action server /arm \(control_msgs/FollowJoint") as caught:
        run(client.wait_for_server)
    assert caught.value.cause == "deadlock"


def test_an_action_server_of_the_controller_listens(actions, scheduler):
    assert not scheduler.listens()
    serve(actions, [], by_controller=False)
    assert not scheduler.listens()
    serve(actions, [])
    assert scheduler.listens()
