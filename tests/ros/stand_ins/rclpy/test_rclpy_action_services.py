"""rclpy: the services and topics of an action, called and heard by a program itself.

Sources: ros2/rcl `rcl_action/src/rcl_action/{action_server,names}.c`, action_msgs
`srv/CancelGoal.srv`.
"""

PROGRAM = """\
import rclpy, uuid
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from control_msgs.action import GripperCommand
from rclpy.action import ActionServer, CancelResponse
from unique_identifier_msgs.msg import UUID

rclpy.init()
node = rclpy.create_node("arm")
Impl = GripperCommand.Impl
BELOW = "/hand/_action/"
send = node.create_client(Impl.SendGoalService, BELOW + "send_goal")
cancel = node.create_client(Impl.CancelGoalService, BELOW + "cancel_goal")
fetch = node.create_client(Impl.GetResultService, BELOW + "get_result")
before = send.service_is_ready()
feedback, statuses = [], []
node.create_subscription(Impl.FeedbackMessage, BELOW + "feedback", feedback.append, 10)
node.create_subscription(GoalStatusArray, BELOW + "status", statuses.append, 10)

def call(client, request):
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    return future.result()

def goal(number, position=0.0):
    request = Impl.SendGoalService.Request(goal_id=UUID(uuid=[number] * 16))
    request.goal.command.position = position
    return request

def number(n):
    return UUID(uuid=[n] * 16)

handles = []
"""


def test_who_sends_a_goal_by_its_service_gets_feedback_status_and_result(run_ros2):
    def main():
        space: dict = {}
        exec(PROGRAM, space)
        rclpy, node, call = space["rclpy"], space["node"], space["call"]
        gripper, goal, number = space["GripperCommand"], space["goal"], space["number"]

        def execute(handle):
            handle.publish_feedback(gripper.Feedback(position=handle.request.command.position))
            handle.succeed()
            return gripper.Result(reached_goal=True)

        server = space["ActionServer"](node, gripper, "/hand", execute, result_timeout=2)
        accepted = call(space["send"], goal(1, 0.25)).accepted
        again = call(space["send"], goal(1)).accepted
        result = call(space["fetch"], space["Impl"].GetResultService.Request(goal_id=number(1)))
        unknown = call(space["fetch"], space["Impl"].GetResultService.Request(goal_id=number(9)))
        rclpy.spin_once(node, timeout_sec=0.1)
        known = len(server._goal_handles)
        import time

        time.sleep(2.5)
        forgotten = len(server._goal_handles)
        positions = [each.feedback.position for each in space["feedback"]]
        last = space["statuses"][-1].status_list[0].status
        server.destroy()
        return (
            space["before"],
            (accepted, again),
            (result.status, result.result.reached_goal, unknown.status),
            positions,
            last,
            (known, forgotten),
            space["send"].service_is_ready(),
        )

    assert run_ros2(main) == (False, (True, False), (4, True, 0), [0.25], 4, (1, 0), False)


def test_goals_are_cancelled_by_their_service_one_or_all(run_ros2):
    def main():
        space: dict = {}
        exec(PROGRAM, space)
        node, call, goal, number = space["node"], space["call"], space["goal"], space["number"]
        handles = space["handles"]
        answers = {3: space["CancelResponse"].REJECT}
        space["ActionServer"](
            node,
            space["GripperCommand"],
            "/hand",
            lambda handle: None,
            handle_accepted_callback=handles.append,
            cancel_callback=lambda handle: answers.get(
                handle.goal_id.uuid[0], space["CancelResponse"].ACCEPT
            ),
        )
        for each in (1, 2, 3):
            assert call(space["send"], goal(each)).accepted

        def cancelled(which):
            request = space["CancelGoal"].Request()
            request.goal_info.goal_id = number(which)
            response = call(space["cancel"], request)
            return response.return_code, [g.goal_id.uuid[0] for g in response.goals_canceling]

        return cancelled(1), cancelled(3), cancelled(7), cancelled(0)

    assert run_ros2(main) == ((0, [1]), (1, []), (2, []), (0, [1, 2]))


def test_the_graph_knows_the_actions_of_a_node(run_ros2):
    def main():
        import pytest
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import (
            ActionClient,
            ActionServer,
            get_action_client_names_and_types_by_node,
            get_action_names_and_types,
            get_action_server_names_and_types_by_node,
        )
        from rclpy.node import NodeNameNonExistentError

        rclpy.init()
        node, other = rclpy.create_node("arm"), rclpy.create_node("eye")
        client = ActionClient(node, GripperCommand, "left")
        ActionServer(other, GripperCommand, "right", lambda handle: None)
        with pytest.raises(NodeNameNonExistentError):
            get_action_client_names_and_types_by_node(node, "nobody", "/")
        entities = client.get_num_entities()
        return (
            get_action_names_and_types(node),
            get_action_client_names_and_types_by_node(other, "arm", "/"),
            get_action_server_names_and_types_by_node(node, "eye", "/"),
            (entities.num_subscriptions, entities.num_clients, entities.num_services),
        )

    kind = ["control_msgs/action/GripperCommand"]
    left, right = ("/left", kind), ("/right", kind)
    assert run_ros2(main) == ([left, right], [left], [right], (2, 3, 0))
