import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node


class Gripper(Node):
    def __init__(self):
        super().__init__("gripper")
        self.server = ActionServer(self, GripperCommand, "grip", self.execute)

    def execute(self, handle):
        print("execute", handle.request.command.position, handle.is_active, handle.is_cancel_requested)
        feedback = GripperCommand.Feedback()
        for position in (0.03, 0.02, 0.01):
            feedback.position = position
            handle.publish_feedback(feedback)
        handle.succeed()
        print("status", handle.status, handle.is_active)
        return GripperCommand.Result(position=0.01, reached_goal=True)


class User(Node):
    def __init__(self):
        super().__init__("user")
        self.client = ActionClient(self, GripperCommand, "grip")
        self.finished, self.heard = rclpy.task.Future(), []

    def send(self, position):
        goal = GripperCommand.Goal()
        goal.command.position = position
        self.client.wait_for_server()
        self.client.send_goal_async(goal, feedback_callback=self.on_feedback).add_done_callback(self.on_response)

    def on_feedback(self, message):
        self.heard.append(message.feedback.position)

    def on_response(self, future):
        handle = future.result()
        print("accepted", handle.accepted, type(handle).__name__, len(handle.goal_id.uuid))
        handle.get_result_async().add_done_callback(self.on_result)

    def on_result(self, future):
        answer = future.result()
        print("result", answer.status, answer.result.position, answer.result.reached_goal)
        self.finished.set_result(True)


rclpy.init()
gripper, user = Gripper(), User()
executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(gripper)
executor.add_node(user)
user.send(0.01)
executor.spin_until_future_complete(user.finished, timeout_sec=10.0)
for _ in range(5):
    executor.spin_once(timeout_sec=0.1)
print("finished", user.finished.done(), user.heard)
print(user.client.server_is_ready())
for ask in (lambda: user.client.send_goal_async(GripperCommand.Result()), lambda: user.client.send_goal("x")):
    try:
        ask()
    except Exception as error:
        print(type(error).__name__)
gripper.server.destroy()
executor.shutdown()
