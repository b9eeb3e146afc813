// A cell that plans with MoveIt: a pose, a straight path, named states and joints.
#include <moveit/move_group_interface/move_group_interface.h>
#include <moveit/planning_scene_interface/planning_scene_interface.h>
#include <ros/ros.h>

#include <cmath>

class Picker {
 public:
  Picker() : arm_("panda_arm"), hand_("hand") { arm_.setMaxVelocityScalingFactor(0.5); }
  void home();
  bool approach();
  bool lower();
  void grip();
  bool retreat();
  bool isFreshTargetUsual();

 private:
  moveit::planning_interface::MoveGroupInterface arm_, hand_;
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
  geometry_msgs::Pose pose = arm_.getCurrentPose().pose;
  if (std::abs(pose.position.x - 0.307) > 0.01 || std::abs(pose.position.z - 0.590) > 0.01) {
    ROS_ERROR("not at the ready pose");
  }
  if (std::abs(arm_.getCurrentJointValues()[3] + 2.356) > 0.01) ROS_ERROR("joint 4 is elsewhere");
  pose.position.x = 0.45, pose.position.y = 0.2, pose.position.z = 0.4;
  arm_.setPoseTarget(pose);
  moveit::planning_interface::MoveGroupInterface::Plan plan;
  if (arm_.plan(plan) != moveit::planning_interface::MoveItErrorCode::SUCCESS) return false;
  return arm_.execute(plan) == moveit::planning_interface::MoveItErrorCode::SUCCESS;
}

bool Picker::lower()
{
  std::vector<geometry_msgs::Pose> way = {arm_.getCurrentPose().pose};
  way[0].position.z -= 0.1;
  moveit_msgs::RobotTrajectory trajectory;
  return arm_.computeCartesianPath(way, 0.01, 0.0, trajectory) > 0.99 &&
         bool(arm_.execute(trajectory));
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

// The joints that a target does not name are at zero, or midway where that is out of their limits.
bool Picker::isFreshTargetUsual()
{
  const std::vector<std::string>& links = arm_.getLinkNames();  // those behind fixed joints too
  if (links.size() != 8 || links[0] != "panda_link1" || links[7] != "panda_link8") return false;
  moveit::planning_interface::MoveGroupInterface::Plan plan;
  const bool isWithin = arm_.setJointValueTarget("panda_joint1", 0.3);
  if (!isWithin || arm_.setJointValueTarget("panda_joint2", 9.0)) return false;
  arm_.setJointValueTarget("panda_joint2", 0.1);
  if (!arm_.plan(plan)) return false;
  const auto& end = plan.trajectory_.joint_trajectory.points.back().positions;
  return std::abs(end[0] - 0.3) < 0.001 && std::abs(end[3] + 1.5708) < 0.01 && std::abs(end[4]) < 0.001;
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "picker");
  ros::AsyncSpinner spinner(1);
  spinner.start();
  moveit::planning_interface::PlanningSceneInterface scene;
  moveit_msgs::CollisionObject box;
  box.id = "box";
  box.header.frame_id = "panda_link0";
  box.primitives.resize(1);
  box.primitives[0].type = shape_msgs::SolidPrimitive::BOX;
  box.primitives[0].dimensions = {0.1, 0.1, 0.1};
  box.primitive_poses.resize(1);
  box.primitive_poses[0].position.x = -0.5;
  box.primitive_poses[0].orientation.w = 1.0;
  scene.applyCollisionObject(box, std_msgs::ColorRGBA());
  const moveit::planning_interface::PlanningSceneInterface& fixed = scene;
  fixed.removeCollisionObjects({"none"});
  Picker picker;
  const bool isUsual = picker.isFreshTargetUsual();
  picker.home();
  const bool isAbove = picker.approach();
  const bool isDown = picker.lower();
  picker.grip();
  const bool isAway = picker.retreat();
  const bool isKnown = scene.getKnownObjectNames() == std::vector<std::string>{"box"} &&
                       scene.getObjectPoses({"box"}).at("box").position.x == -0.5 &&
                       scene.getAttachedObjects().empty();
  return isUsual && isAbove && isDown && isAway && isKnown ? 0 : 1;
}
