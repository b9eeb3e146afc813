import actionlib
import rospy
from actionlib.msg import TestAction, TestGoal, TestResult


def serve(goal):
    server.set_succeeded(TestResult(goal.goal + 1))


def main():
    global server
    rospy.init_node("server_outlives_main")
    server = actionlib.SimpleActionServer("count", TestAction, serve, False)
    server.start()
    client = actionlib.SimpleActionClient("count", TestAction)
    client.wait_for_server()
    print("> state", client.send_goal_and_wait(TestGoal(4)), client.get_result().result)


if __name__ == "__main__":
    main()
