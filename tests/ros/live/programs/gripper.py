import actionlib
import rospy
from control_msgs.msg import GripperCommandAction, GripperCommandGoal


def close(client):
    goal = GripperCommandGoal()
    goal.command.position = 0.0
    goal.command.max_effort = 10.0
    client.send_goal(goal)
    client.wait_for_result()
    result = client.get_result()
    print("> closed", client.get_state(), result.reached_goal, round(result.position, 2))


def open_wide(client):
    goal = GripperCommandGoal()
    goal.command.position = 0.03
    client.send_goal_and_wait(goal)
    print("> opened", client.get_state(), round(client.get_result().position, 2))


def main():
    rospy.init_node("gripper")
    client = actionlib.SimpleActionClient("/gripper_controller/gripper_cmd", GripperCommandAction)
    client.wait_for_server()
    close(client)
    open_wide(client)


if __name__ == "__main__":
    main()
