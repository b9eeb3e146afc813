// A cell that plans with MoveIt 2: named states, a pose, a straight path, joints, the planning scene.
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <moveit/move_group_interface/move_group_interface.hpp>
#include <moveit/planning_scene_interface/planning_scene_interface.h>
#include <rclcpp/rclcpp.hpp>

using moveit::core::MoveItErrorCode;
using moveit::planning_interface::MoveGroupInterface;

class Picker {
 public:
  explicit Picker(const rclcpp::Node::SharedPtr& node)
      : logger_(node->get_logger()), arm_(node, "panda_arm"), hand_(node, "hand")
  {
    arm_.setMaxVelocityScalingFactor(0.5);
    arm_.setMaxAccelerationScalingFactor(0.5);
    arm_.setPlanningTime(5.0);
  }
  void home();
  bool approach();
  bool lower();
  void grip();
  bool retreat();
  bool isUnreachable();
  bool isFreshTargetUsual();

 private:
  rclcpp::Logger logger_;
  MoveGroupInterface arm_, hand_;
};

void Picker::home()
{
  arm_.setNamedTarget("ready");
  arm_.move();
  hand_.setNamedTarget("open");
  hand_.move();
}

bool Picker::approach()
{
  geometry_msgs::msg::Pose pose = arm_.getCurrentPose().pose;
  if (std::abs(pose.position.x - 0.307) > 0.01 || std::abs(pose.position.z - 0.590) > 0.01)
    RCLCPP_ERROR(logger_, "not at the ready pose: %f %f", pose.position.x, pose.position.z);
  if (std::abs(arm_.getCurrentJointValues()[3] + 2.356) > 0.01)
    RCLCPP_ERROR(logger_, "joint 4 is elsewhere");
  pose.position.x = 0.45, pose.position.y = 0.2, pose.position.z = 0.4;
  arm_.setPoseTarget(pose);
  MoveGroupInterface::Plan plan;
  if (arm_.plan(plan) != MoveItErrorCode::SUCCESS) return false;
  const MoveGroupInterface::Plan copied = plan;
  return copied.trajectory.joint_trajectory.points == copied.trajectory_.joint_trajectory.points &&
         arm_.execute(copied) == MoveItErrorCode::SUCCESS;
}

bool Picker::lower()
{
  std::vector<geometry_msgs::msg::Pose> way = {arm_.getCurrentPose().pose};
  way[0].position.z -= 0.1;
  moveit_msgs::msg::RobotTrajectory trajectory;
  return arm_.computeCartesianPath(way, 0.01, trajectory) > 0.99 && bool(arm_.execute(trajectory));
}

void Picker::grip()
{
  hand_.setJointValueTarget("panda_finger_joint1", 0.01);
  hand_.move();
}

bool Picker::retreat()
{
  std::vector<double> joints = arm_.getCurrentJointValues();
  joints[0] -= 0.5;
  arm_.setJointValueTarget(joints);
  return bool(arm_.move());
}

bool Picker::isUnreachable()
{
  arm_.setPositionTarget(9.0, 0.0, 0.5);
  MoveGroupInterface::Plan plan;
  return !arm_.plan(plan);
}

// The joints that a target does not name are at zero, or midway where that is out of their limits.
bool Picker::isFreshTargetUsual()
{
  MoveGroupInterface::Plan plan;
  const bool isWithin = arm_.setJointValueTarget("panda_joint1", 0.3);
  if (!isWithin || arm_.setJointValueTarget("panda_joint2", 9.0)) return false;
  arm_.setJointValueTarget("panda_joint2", 0.1);
  if (!arm_.plan(plan)) return false;
  const auto& end = plan.trajectory.joint_trajectory.points.back().positions;
  return std::abs(end[0] - 0.3) < 0.001 && std::abs(end[3] + 1.5708) < 0.01 && std::abs(end[4]) < 0.001;
}

moveit_msgs::msg::CollisionObject box()
{
  moveit_msgs::msg::CollisionObject box;
  box.id = "box";
  box.header.frame_id = "panda_link0";
  box.primitives.resize(1);
  box.primitives[0].type = shape_msgs::msg::SolidPrimitive::BOX;
  box.primitives[0].dimensions = {0.1, 0.1, 0.1};
  box.primitive_poses.resize(1);
  box.primitive_poses[0].position.x = -0.5;
  box.primitive_poses[0].orientation.w = 1.0;
  return box;
}

int main(int argc, char** argv)
{
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<rclcpp::Node>("picker");
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  std::thread spinning([&executor] { executor.spin(); });
  bool isWell = false;
  {
    moveit::planning_interface::PlanningSceneInterface scene;
    scene.applyCollisionObject(box());
    Picker picker(node);
    isWell = picker.isFreshTargetUsual();
    picker.home();
    isWell = isWell && picker.approach() && picker.lower();
    picker.grip();
    isWell = isWell && picker.retreat();
    isWell = isWell && scene.getKnownObjectNames() == std::vector<std::string>{"box"} &&
             scene.getObjects().count("box") == 1 && scene.getAttachedObjects().empty();
    if (argc > 1 && std::string(argv[1]) == "--far") isWell = picker.isUnreachable();
  }
  rclcpp::shutdown();
  spinning.join();
  return isWell ? 0 : 1;
}
