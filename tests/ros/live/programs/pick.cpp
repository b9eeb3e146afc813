// A cell of two actions: an arm that follows trajectories and a gripper.
#include <actionlib/client/simple_action_client.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <control_msgs/GripperCommandAction.h>
#include <ros/ros.h>

namespace cell {

typedef actionlib::SimpleActionClient<control_msgs::FollowJointTrajectoryAction> ArmClient;
typedef actionlib::SimpleActionClient<control_msgs::GripperCommandAction> HandClient;

class Cell {
 public:
  Cell()
      : arm_("/panda_arm_controller/follow_joint_trajectory", true),
        hand_("/panda_hand_controller/gripper_cmd", true)
  {
    arm_.waitForServer();
    hand_.waitForServer();
  }
  void pick();
  void place();
  void home() { swing(0.0, 1.0); }

 private:
  bool swing(double angle, double seconds);
  bool grip(double width);

  ArmClient arm_;
  HandClient hand_;
};

bool Cell::swing(double angle, double seconds)
{
  control_msgs::FollowJointTrajectoryGoal goal;
  const double rest[] = {0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785};
  trajectory_msgs::JointTrajectoryPoint point;
  for (int i = 0; i < 7; ++i) {
    goal.trajectory.joint_names.push_back("panda_joint" + std::to_string(i + 1));
    point.positions.push_back(i == 0 ? angle : rest[i]);
  }
  point.time_from_start = ros::Duration(seconds);
  goal.trajectory.points.push_back(point);
  arm_.sendGoal(goal);
  bool in_time = arm_.waitForResult(ros::Duration(10.0));
  ROS_INFO("swing to %.2f: %s %s", angle, in_time ? "in time" : "late",
           arm_.getState().toString().c_str());
  return in_time;
}

bool Cell::grip(double width)
{
  control_msgs::GripperCommandGoal goal;
  goal.command.position = width;
  goal.command.max_effort = 10.0;
  hand_.sendGoal(goal);
  return hand_.waitForResult(ros::Duration(5.0));
}

void Cell::pick()
{
  grip(0.04);
  swing(0.5, 1.0);
  grip(0.02);
}

void Cell::place()
{
  swing(-0.3, 1.5);
  grip(0.04);
}

}  // namespace cell

int main(int argc, char** argv)
{
  ros::init(argc, argv, "pick_cpp");
  ros::NodeHandle node;
  cell::Cell cell;
  cell.pick();
  cell.place();
  cell.home();
  return 0;
}
