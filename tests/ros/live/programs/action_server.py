import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult


class Counter:
    def __init__(self):
        self.server = actionlib.SimpleActionServer("count", TestAction, self.count, False)
        self.server.start()

    def count(self, goal):
        for number in range(goal.goal):
            if self.server.is_preempt_requested():
                self.server.set_preempted(TestResult(number), "stopped")
                return
            # A client drops what comes before it knows of its own goal.
            rospy.sleep(0.1)
            self.server.publish_feedback(TestFeedback(number))
        if goal.goal == 2:
            self.server.set_aborted(TestResult(-1), "two is too few")
        else:
            self.server.set_succeeded(TestResult(goal.goal), "counted")


def main():
    rospy.init_node("action_server")
    Counter()
    client = actionlib.SimpleActionClient("count", TestAction)
    print("> server", client.wait_for_server(rospy.Duration(5)))
    heard = []
    client.send_goal(TestGoal(4), feedback_cb=lambda f: heard.append(f.feedback))
    client.wait_for_result()
    print("> four", client.get_state(), client.get_result().result, heard)
    print("> two", client.send_goal_and_wait(TestGoal(2)), client.get_goal_status_text())
    client.send_goal(TestGoal(50))
    rospy.sleep(0.55)
    client.cancel_goal()
    client.wait_for_result()
    print("> fifty", client.get_state(), client.get_goal_status_text())
    rospy.signal_shutdown("counted")


if __name__ == "__main__":
    main()
