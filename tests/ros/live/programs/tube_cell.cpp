// The published case: a Panda moves ten test tubes from one rack to another, in five functions.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <control_msgs/GripperCommandAction.h>
#include <geometry_msgs/Pose.h>
#include <moveit_msgs/GetPositionIK.h>
#include <ros/ros.h>

namespace {

// The racks stand left and right of the robot's base; both have ten slots in a row along x.
const double kFirstSlotX = 0.30;
const double kSlotPitch = 0.04;
const double kSourceRackY = 0.20;
const double kTargetRackY = -0.20;
const int kTubes = 10;

// Heights of panda_link8, which is 0.1034 m above the point between the finger tips.
const double kTravelHeight = 0.3384;
const double kGraspHeight = 0.1884;
const double kReleaseHeight = 0.1904;

const double kOpen = 0.035;
const double kClosed = 0.0;
const double kSpeed = 0.8;  // of a joint, rad/s
const std::vector<double> kReady = {0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785};

}  // namespace

class TubeCell {
 public:
  TubeCell();
  void init();
  void pickPosition(int slot);
  void pick();
  void placePosition(int slot);
  void place();

 private:
  void goTo(double x, double y, double height);
  void straightTo(double height);
  void follow(const std::vector<std::vector<double>>& points);
  void grip(double width);
  std::vector<double> solve(double x, double y, double height, const std::vector<double>& seed);

  ros::NodeHandle node_;
  ros::ServiceClient ik_;
  actionlib::SimpleActionClient<control_msgs::FollowJointTrajectoryAction> arm_;
  actionlib::SimpleActionClient<control_msgs::GripperCommandAction> hand_;
  std::vector<double> joints_ = kReady;
  double x_ = 0.0, y_ = 0.0, height_ = 0.0;
};

TubeCell::TubeCell()
    : ik_(node_.serviceClient<moveit_msgs::GetPositionIK>("compute_ik")),
      arm_("panda_arm_controller/follow_joint_trajectory", true),
      hand_("panda_hand_controller/gripper_cmd", true)
{
  ik_.waitForExistence();
  arm_.waitForServer();
  hand_.waitForServer();
}

std::vector<double> TubeCell::solve(double x, double y, double height,
                                    const std::vector<double>& seed)
{
  moveit_msgs::GetPositionIK ik;
  ik.request.ik_request.group_name = "panda_arm";
  ik.request.ik_request.ik_link_name = "panda_link8";
  ik.request.ik_request.pose_stamped.header.frame_id = "panda_link0";
  geometry_msgs::Pose& pose = ik.request.ik_request.pose_stamped.pose;
  pose.position.x = x;
  pose.position.y = y;
  pose.position.z = height;
  pose.orientation.x = 0.9238795;
  pose.orientation.y = -0.3826834;
  for (size_t i = 0; i < seed.size(); ++i) {
    ik.request.ik_request.robot_state.joint_state.name.push_back("panda_joint" +
                                                                 std::to_string(i + 1));
  }
  ik.request.ik_request.robot_state.joint_state.position = seed;
  if (!ik_.call(ik) || ik.response.error_code.val != moveit_msgs::MoveItErrorCodes::SUCCESS) {
    throw std::runtime_error("no joint angles reach the pose");
  }
  const auto& state = ik.response.solution.joint_state;
  std::vector<double> joints;
  for (size_t i = 0; i < state.name.size() && joints.size() < 7; ++i) {
    if (state.name[i].find("panda_joint") == 0) joints.push_back(state.position[i]);
  }
  return joints;
}

void TubeCell::follow(const std::vector<std::vector<double>>& points)
{
  control_msgs::FollowJointTrajectoryGoal goal;
  for (int i = 1; i <= 7; ++i) {
    goal.trajectory.joint_names.push_back("panda_joint" + std::to_string(i));
  }
  double time = 0.0;
  for (const auto& joints : points) {
    double farthest = 0.0;
    for (int i = 0; i < 7; ++i) farthest = std::max(farthest, std::abs(joints[i] - joints_[i]));
    time += std::max(farthest / kSpeed, 0.05);
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = joints;
    point.time_from_start = ros::Duration(time);
    goal.trajectory.points.push_back(point);
    joints_ = joints;
  }
  arm_.sendGoal(goal);
  if (!arm_.waitForResult(ros::Duration(time + 10.0)) ||
      arm_.getState() != actionlib::SimpleClientGoalState::SUCCEEDED) {
    throw std::runtime_error("the arm did not arrive: " + arm_.getState().toString());
  }
}

void TubeCell::goTo(double x, double y, double height)
{
  x_ = x, y_ = y, height_ = height;
  follow({solve(x, y, height, joints_)});
}

void TubeCell::straightTo(double height)
{
  const int steps = 10;
  std::vector<std::vector<double>> points;
  std::vector<double> seed = joints_;
  for (int step = 1; step <= steps; ++step) {
    seed = solve(x_, y_, height_ + (height - height_) * step / steps, seed);
    points.push_back(seed);
  }
  height_ = height;
  follow(points);
}

void TubeCell::grip(double width)
{
  control_msgs::GripperCommandGoal goal;
  goal.command.position = width;
  goal.command.max_effort = 20.0;
  hand_.sendGoal(goal);
  if (!hand_.waitForResult(ros::Duration(10.0))) throw std::runtime_error("the hand is stuck");
}

// Go to the ready pose with an open gripper.
void TubeCell::init()
{
  follow({kReady});
  grip(kOpen);
}

// Go above the tube.
void TubeCell::pickPosition(int slot)
{
  goTo(kFirstSlotX + kSlotPitch * slot, kSourceRackY, kTravelHeight);
}

// Take the tube out of the rack.
void TubeCell::pick()
{
  straightTo(kGraspHeight);
  grip(kClosed);
  straightTo(kTravelHeight);
}

// Carry the tube to its slot and let it down.
void TubeCell::placePosition(int slot)
{
  goTo(kFirstSlotX + kSlotPitch * slot, kTargetRackY, kTravelHeight);
  straightTo(kReleaseHeight);
}

// Let go of the tube.
void TubeCell::place()
{
  grip(kOpen);
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "tube_cell");
  TubeCell cell;
  for (int tube = 0; tube < kTubes && ros::ok(); ++tube) {
    cell.init();
    cell.pickPosition(tube);
    cell.pick();
    cell.placePosition(tube);
    cell.place();
    ROS_INFO("tube %d of %d is in its rack", tube + 1, kTubes);
  }
  return 0;
}
