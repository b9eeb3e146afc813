"""rclpy.action: goal future, handle, result future; servers decide by callbacks.

Source: ros2/rclpy (branch jazzy) `rclpy/action/{client,server}.py`.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver


def test_a_goal_is_answered_fed_back_and_ends_with_a_result(run_ros2):
    def main():
        import time

        import rclpy
        from action_msgs.msg import GoalStatus
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer

        rclpy.init()
        node = rclpy.create_node("arm")
        order = []

        def execute(handle):
            handle.publish_feedback(GripperCommand.Feedback(position=0.5))
            time.sleep(0.5)
            handle.succeed()
            return GripperCommand.Result(position=handle.request.command.position)

        ActionServer(node, GripperCommand, "grip", execute)
        client = ActionClient(node, GripperCommand, "grip")
        assert client.wait_for_server(timeout_sec=1.0)
        goal = GripperCommand.Goal()
        goal.command.position = 0.25
        sent = client.send_goal_async(
            goal, feedback_callback=lambda message: order.append(message.feedback.position)
        )
        rclpy.spin_until_future_complete(node, sent)
        handle = sent.result()
        future = handle.get_result_async()
        future.add_done_callback(lambda done: order.append(done.result().result.position))
        rclpy.spin_until_future_complete(node, future)
        for _ in range(20):
            rclpy.spin_once(node, timeout_sec=0.1)
        return handle.accepted, future.result().status == GoalStatus.STATUS_SUCCEEDED, order

    assert run_ros2(main) == (True, True, [0.5, 0.25])


def test_the_private_way_to_a_result_that_programs_take(run_ros2):
    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer

        def execute(handle):
            handle.succeed()
            return GripperCommand.Result(position=0.5)

        rclpy.init()
        node = rclpy.create_node("arm")
        ActionServer(node, GripperCommand, "grip", execute)
        client = ActionClient(node, GripperCommand, "grip")
        sent = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, sent)
        ended = client._get_result_async(sent.result())
        rclpy.spin_until_future_complete(node, ended)
        return ended.result().result.position

    assert run_ros2(main) == 0.5


def test_a_server_may_refuse_a_goal(run_ros2):
    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer, GoalResponse

        rclpy.init()
        node = rclpy.create_node("arm")
        ActionServer(
            node, GripperCommand, "grip", print, goal_callback=lambda goal: GoalResponse.REJECT
        )
        client = ActionClient(node, GripperCommand, "grip")
        with pytest.raises(TypeError):
            client.send_goal_async(GripperCommand.Result())
        future = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, future)
        return future.result().accepted

    assert run_ros2(main) is False


def test_a_cancel_request_that_waited_for_the_goals_end_finds_it_terminated(run_ros2):
    def main():
        import threading
        import time

        import rclpy
        from action_msgs.srv import CancelGoal
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer
        from rclpy.executors import SingleThreadedExecutor

        rclpy.init()
        server, node = rclpy.create_node("hand"), rclpy.create_node("arm")

        def execute(handle):
            time.sleep(2.0)
            handle.succeed()
            return GripperCommand.Result()

        ActionServer(server, GripperCommand, "grip", execute)
        executor = SingleThreadedExecutor()
        executor.add_node(server)
        threading.Thread(target=executor.spin, daemon=True).start()
        client = ActionClient(node, GripperCommand, "grip")
        client.wait_for_server()
        sent = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, sent)
        cancel = sent.result().cancel_goal_async()
        rclpy.spin_until_future_complete(node, cancel)
        answer = cancel.result()
        assert answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
        return len(answer.goals_canceling)

    assert run_ros2(main) == 0


@pytest.mark.parametrize("accepts", [True, False])
def test_a_cancel_request_is_decided_by_the_server(run_ros2, accepts):
    def main():
        import time

        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer, CancelResponse
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.executors import MultiThreadedExecutor

        rclpy.init()
        node = rclpy.create_node("arm")
        executor = MultiThreadedExecutor(num_threads=4)

        def execute(handle):
            for _ in range(20):
                if handle.is_cancel_requested:
                    handle.canceled()
                    return GripperCommand.Result()
                time.sleep(0.1)
            handle.succeed()
            return GripperCommand.Result(reached_goal=True)

        ActionServer(
            node,
            GripperCommand,
            "grip",
            execute,
            callback_group=ReentrantCallbackGroup(),
            cancel_callback=lambda handle: (
                CancelResponse.ACCEPT if accepts else CancelResponse.REJECT
            ),
        )
        client = ActionClient(node, GripperCommand, "grip")
        sent = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, sent, executor)
        cancel = sent.result().cancel_goal_async()
        rclpy.spin_until_future_complete(node, cancel, executor)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(node, result, executor)
        return len(cancel.result().goals_canceling), result.result().status

    assert run_ros2(main) == ((1, 5) if accepts else (0, 4))


def test_a_goal_whose_state_was_not_set_is_aborted(run_ros2):
    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer

        rclpy.init()
        node = rclpy.create_node("arm")

        def execute(handle):
            raise ValueError("lost")

        ActionServer(node, GripperCommand, "grip", execute)
        client = ActionClient(node, GripperCommand, "grip")
        sent = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, sent)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(node, result)
        return result.result().status

    assert run_ros2(main) == 6


def test_a_goal_that_nobody_serves_is_a_deadlock_that_names_the_action(run_ros2):
    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient

        rclpy.init()
        node = rclpy.create_node("arm")
        client = ActionClient(node, GripperCommand, "grip")
        assert client.wait_for_server(timeout_sec=0.5) is False
        assert client.server_is_ready() is False
        future = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, future)

    with pytest.raises(RunOver, match=r"/grip \(control_msgs/GripperCommand\)") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_client_that_waits_in_the_callback_of_its_own_group_is_a_deadlock(run_ros2):
    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer

        rclpy.init()
        node, server = rclpy.create_node("arm"), rclpy.create_node("grip")
        ActionServer(server, GripperCommand, "grip", print)
        client = ActionClient(node, GripperCommand, "grip")

        def beat():
            rclpy.spin_until_future_complete(node, client.send_goal_async(GripperCommand.Goal()))

        node.create_timer(0.1, beat)
        rclpy.spin(node)

    with pytest.raises(RunOver, match="the answer of action server /grip") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"
