import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("n")
trigger = node.create_client(Trigger, "check")


def check(request, response):
    response.success = True
    return response


node.create_service(Trigger, "check", check)


async def execute(handle):
    print("execute", handle.request.command.max_effort)
    checked = await trigger.call_async(Trigger.Request())
    print("checked", checked.success)
    handle.succeed()
    return GripperCommand.Result(effort=handle.request.command.max_effort)


ActionServer(node, GripperCommand, "grip", execute)
client = ActionClient(node, GripperCommand, "grip")
client.wait_for_server()
trigger.wait_for_service()


async def mission():
    goal = GripperCommand.Goal()
    goal.command.max_effort = 20.0
    handle = await client.send_goal_async(goal)
    print("accepted", handle.accepted)
    answer = await handle.get_result_async()
    print("status", answer.status, answer.result.effort)
    return "over"


executor = rclpy.executors.SingleThreadedExecutor()
executor.add_node(node)
task = executor.create_task(mission())
executor.spin_until_future_complete(task, timeout_sec=10.0)
print(task.result())
