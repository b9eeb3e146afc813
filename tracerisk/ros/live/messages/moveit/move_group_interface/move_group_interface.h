// MoveIt's MoveGroupInterface for machines without MoveIt: over the actions, services and parameters
// of move_group, header only. Given by `tracerisk headers`; what it lacks does not compile.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <geometry_msgs/PoseStamped.h>
#include <moveit/robot_state/robot_state.h>
#include <moveit/utils/moveit_error_code.h>
#include <moveit_msgs/AttachedCollisionObject.h>
#include <moveit_msgs/ExecuteTrajectoryAction.h>
#include <moveit_msgs/GetCartesianPath.h>
#include <moveit_msgs/GetPositionFK.h>
#include <moveit_msgs/MoveGroupAction.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <shape_msgs/SolidPrimitive.h>
#include <std_msgs/String.h>

namespace moveit {
namespace planning_interface {

using moveit::core::MoveItErrorCode;

class MoveGroupInterface {
 public:
  struct Plan {
    moveit_msgs::RobotState start_state_;
    moveit_msgs::RobotTrajectory trajectory_;
    double planning_time_ = 0.0;
  };

  struct Options {
    explicit Options(std::string group) : group_name_(std::move(group)) {}
    std::string group_name_;
    ros::NodeHandle node_handle_;
  };

  MoveGroupInterface(const std::string& group) : MoveGroupInterface(Options(group)) {}

  MoveGroupInterface(const Options& options)
      : node_(options.node_handle_),
        move_(node_, "move_group", false),
        execute_(node_, "execute_trajectory", false)
  {
    model_ = moveit::core::RobotModel::get();
    group_ = model_->getJointModelGroup(options.group_name_);
    if (group_ == nullptr) {
      const std::string error = "Group '" + options.group_name_ + "' was not found.";
      ROS_FATAL_STREAM(error);
      throw std::runtime_error(error);
    }
    tip_ = model_->tip(group_->getName());
    frame_ = model_->getModelFrame();
    const std::string defaults = "robot_description_planning/default_";
    node_.param(defaults + "velocity_scaling_factor", velocity_, 0.1);
    node_.param(defaults + "acceleration_scaling_factor", acceleration_, 0.1);
    attached_ = node_.advertise<moveit_msgs::AttachedCollisionObject>("attached_collision_object", 1);
    stop_ = node_.advertise<std_msgs::String>("trajectory_execution_event", 1);
    cartesian_ = node_.serviceClient<moveit_msgs::GetCartesianPath>("compute_cartesian_path");
    forward_ = node_.serviceClient<moveit_msgs::GetPositionFK>("compute_fk");
    states_ = node_.subscribe("joint_states", 100, &MoveGroupInterface::heard, this);
    connect(move_);
    connect(execute_);
  }
  MoveGroupInterface(const MoveGroupInterface&) = delete;
  MoveGroupInterface& operator=(const MoveGroupInterface&) = delete;

  // The robot and its groups.
  const std::string& getName() const { return group_->getName(); }
  const std::vector<std::string>& getJointNames() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getJoints() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getActiveJoints() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getVariableNames() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getJointModelGroupNames() const
  {
    if (names_.empty()) names_ = model_->getJointModelGroupNames();
    return names_;
  }
  moveit::core::RobotModelConstPtr getRobotModel() const { return model_; }
  const std::string& getPlanningFrame() const { return model_->getModelFrame(); }
  const std::string& getPoseReferenceFrame() const { return frame_; }
  void setPoseReferenceFrame(const std::string& frame) { frame_ = frame; }
  const std::string& getEndEffectorLink() const { return tip_; }
  bool setEndEffectorLink(const std::string& link) { return tip_ = link, true; }

  // How is planned.
  void setPlanningTime(double seconds) { time_ = seconds > 0.0 ? seconds : time_; }
  double getPlanningTime() const { return time_; }
  void setNumPlanningAttempts(unsigned int attempts) { attempts_ = attempts; }
  void setPlannerId(const std::string& planner) { planner_ = planner; }
  void setPlanningPipelineId(const std::string& pipeline) { pipeline_ = pipeline; }
  void setMaxVelocityScalingFactor(double factor) { velocity_ = factor; }
  void setMaxAccelerationScalingFactor(double factor) { acceleration_ = factor; }
  void allowReplanning(bool replan) { replan_ = replan; }
  void allowLooking(bool look) { look_ = look; }
  void setGoalTolerance(double tolerance)
  {
    setGoalJointTolerance(tolerance);
    setGoalPositionTolerance(tolerance);
    setGoalOrientationTolerance(tolerance);
  }
  void setGoalJointTolerance(double tolerance) { joint_tolerance_ = tolerance; }
  void setGoalPositionTolerance(double tolerance) { position_tolerance_ = tolerance; }
  void setGoalOrientationTolerance(double tolerance) { orientation_tolerance_ = tolerance; }
  void setPathConstraints(const moveit_msgs::Constraints& constraints) { path_ = constraints; }
  void clearPathConstraints() { path_ = moveit_msgs::Constraints(); }
  void setStartStateToCurrentState() { start_ = current(); }
  void setStartState(const moveit_msgs::RobotState& state) { start_ = state; }
  void setStartState(const moveit::core::RobotState& state)
  {
    start_ = moveit_msgs::RobotState();
    start_.joint_state = state.message();
  }

  // Targets.
  std::vector<std::string> getNamedTargets() const
  {
    std::vector<std::string> names;
    for (const auto& state : model_->states(getName())) names.push_back(state.first);
    return names;
  }
  std::map<std::string, double> getNamedTargetValues(const std::string& name) const
  {
    const auto states = model_->states(getName());
    const auto found = states.find(name);
    return found == states.end() ? std::map<std::string, double>() : found->second;
  }
  bool setNamedTarget(const std::string& name)
  {
    if (!model_->states(getName()).count(name)) {
      ROS_ERROR("The requested named target '%s' does not exist", name.c_str());
      return false;
    }
    return setJointValueTarget(getNamedTargetValues(name));
  }
  bool setJointValueTarget(const std::map<std::string, double>& values)
  {
    // As in MoveIt: joints that are not named keep their target, at first where they are.
    if (!hasJointTarget_) fillJoints();
    for (const auto& value : values) joints_[value.first] = value.second;
    return isJointTarget_ = true;
  }
  bool setJointValueTarget(const std::vector<double>& values)
  {
    if (values.size() != getVariableNames().size()) return false;
    std::map<std::string, double> named;
    for (std::size_t i = 0; i < values.size(); ++i) named[getVariableNames()[i]] = values[i];
    hasJointTarget_ = true;
    return setJointValueTarget(named);
  }
  bool setJointValueTarget(const std::string& joint, double value)
  {
    return setJointValueTarget(std::map<std::string, double>{{joint, value}});
  }
  bool setPoseTarget(const geometry_msgs::PoseStamped& pose, const std::string& link = "")
  {
    usePose();
    addPosition(pose.header.frame_id.empty() ? frame_ : pose.header.frame_id, pose.pose.position, link);
    addOrientation(pose.header.frame_id.empty() ? frame_ : pose.header.frame_id,
                   pose.pose.orientation, link);
    return true;
  }
  bool setPoseTarget(const geometry_msgs::Pose& pose, const std::string& link = "")
  {
    geometry_msgs::PoseStamped stamped;
    stamped.pose = pose;
    return setPoseTarget(stamped, link);
  }
  bool setPositionTarget(double x, double y, double z, const std::string& link = "")
  {
    geometry_msgs::Point point;
    point.x = x, point.y = y, point.z = z;
    usePose();
    addPosition(frame_, point, link);
    return true;
  }
  void clearPoseTargets() { pose_ = moveit_msgs::Constraints(); }
  void clearPoseTarget(const std::string& = "") { clearPoseTargets(); }

  // Planning and moving.
  MoveItErrorCode plan(Plan& plan)
  {
    moveit_msgs::MoveGroupGoal goal = request(true);
    const MoveItErrorCode code = sent(move_, goal, true);
    if (const auto result = move_.getResult()) {
      plan.start_state_ = result->trajectory_start;
      plan.trajectory_ = result->planned_trajectory;
      plan.planning_time_ = result->planning_time;
    }
    return code;
  }
  MoveItErrorCode move() { return sent(move_, request(false), true); }
  MoveItErrorCode asyncMove() { return sent(move_, request(false), false); }
  MoveItErrorCode execute(const Plan& plan) { return execute(plan.trajectory_); }
  MoveItErrorCode asyncExecute(const Plan& plan) { return asyncExecute(plan.trajectory_); }
  MoveItErrorCode execute(const moveit_msgs::RobotTrajectory& trajectory)
  {
    return sent(execute_, execution(trajectory), true);
  }
  MoveItErrorCode asyncExecute(const moveit_msgs::RobotTrajectory& trajectory)
  {
    return sent(execute_, execution(trajectory), false);
  }
  double computeCartesianPath(const std::vector<geometry_msgs::Pose>& waypoints, double step,
                              double jump, moveit_msgs::RobotTrajectory& trajectory,
                              bool avoid = true, moveit_msgs::MoveItErrorCodes* code = nullptr)
  {
    return computeCartesianPath(waypoints, step, jump, trajectory, moveit_msgs::Constraints(), avoid,
                                code);
  }
  double computeCartesianPath(const std::vector<geometry_msgs::Pose>& waypoints, double step,
                              double jump, moveit_msgs::RobotTrajectory& trajectory,
                              const moveit_msgs::Constraints& path, bool avoid = true,
                              moveit_msgs::MoveItErrorCodes* code = nullptr)
  {
    moveit_msgs::GetCartesianPath call;
    call.request.start_state = start_;
    call.request.group_name = getName();
    call.request.header.frame_id = frame_;
    call.request.header.stamp = ros::Time::now();
    call.request.waypoints = waypoints;
    call.request.max_step = step;
    call.request.jump_threshold = jump;
    call.request.path_constraints = path;
    call.request.avoid_collisions = avoid;
    call.request.link_name = tip_;
    const bool isCalled = cartesian_.call(call);
    if (code != nullptr) *code = call.response.error_code;
    if (!isCalled || call.response.error_code.val != moveit_msgs::MoveItErrorCodes::SUCCESS) return -1.0;
    trajectory = call.response.solution;
    return call.response.fraction;
  }
  void stop()
  {
    std_msgs::String event;
    event.data = "stop";
    stop_.publish(event);
  }

  // Where the robot is.
  bool startStateMonitor(double seconds = 1.0) { return hasState(seconds); }
  moveit::core::RobotStatePtr getCurrentState(double seconds = 1.0) const
  {
    if (!hasState(seconds)) {
      ROS_ERROR("Failed to fetch current robot state");
      return nullptr;
    }
    std::lock_guard<std::mutex> lock(mutex_);
    auto state = std::make_shared<moveit::core::RobotState>(model_);
    for (const auto& one : heard_) state->setVariablePosition(one.first, one.second);
    return state;
  }
  std::vector<double> getCurrentJointValues() const
  {
    std::vector<double> values;
    if (const auto state = getCurrentState()) state->copyJointGroupPositions(group_, values);
    return values;
  }
  geometry_msgs::PoseStamped getCurrentPose(const std::string& link = "") const
  {
    moveit_msgs::GetPositionFK call;
    call.request.header.frame_id = getPlanningFrame();
    call.request.fk_link_names = {link.empty() ? tip_ : link};
    if (const auto state = getCurrentState()) {
      call.request.robot_state.joint_state = state->message();
    }
    if (!forward_.call(call) || call.response.pose_stamped.empty()) {
      ROS_ERROR("no pose of %s is known", call.request.fk_link_names[0].c_str());
      return geometry_msgs::PoseStamped();
    }
    return call.response.pose_stamped[0];
  }

  // Objects in the hand.
  bool attachObject(const std::string& object, const std::string& link = "",
                    const std::vector<std::string>& touched = {})
  {
    moveit_msgs::AttachedCollisionObject attached;
    attached.link_name = link.empty() ? tip_ : link;
    attached.object.id = object;
    attached.object.operation = moveit_msgs::CollisionObject::ADD;
    attached.touch_links = touched.empty() ? std::vector<std::string>{attached.link_name} : touched;
    attached_.publish(attached);
    return true;
  }
  bool detachObject(const std::string& object = "")
  {
    moveit_msgs::AttachedCollisionObject attached;
    attached.object.id = object;
    attached.object.operation = moveit_msgs::CollisionObject::REMOVE;
    attached_.publish(attached);
    return true;
  }

 private:
  template <typename Client>
  void connect(Client& client) const
  {
    auto* queue = dynamic_cast<ros::CallbackQueue*>(node_.getCallbackQueue());
    while (node_.ok() && !client.isServerConnected()) {
      ros::WallDuration(0.005).sleep();
      if (queue != nullptr) queue->callAvailable();
    }
  }

  // As in MoveIt the user's own spinner takes the results: without one, this waits for ever.
  template <typename Client, typename Goal>
  MoveItErrorCode sent(Client& client, const Goal& goal, bool waits)
  {
    client.sendGoal(goal);
    if (!waits) return MoveItErrorCode::SUCCESS;
    while (node_.ok() && !client.getState().isDone()) ros::WallDuration(0.002).sleep();
    const auto result = client.getResult();
    return result ? MoveItErrorCode(result->error_code) : MoveItErrorCode::FAILURE;
  }

  moveit_msgs::MoveGroupGoal request(bool isPlanOnly) const
  {
    moveit_msgs::MoveGroupGoal goal;
    moveit_msgs::MotionPlanRequest& request = goal.request;
    request.group_name = getName();
    request.start_state = start_;
    request.num_planning_attempts = attempts_;
    request.allowed_planning_time = time_;
    request.planner_id = planner_;
    request.pipeline_id = pipeline_;
    request.max_velocity_scaling_factor = velocity_;
    request.max_acceleration_scaling_factor = acceleration_;
    request.path_constraints = path_;
    request.goal_constraints = {isJointTarget_ ? jointTarget() : pose_};
    goal.planning_options.plan_only = isPlanOnly;
    goal.planning_options.look_around = look_;
    goal.planning_options.replan = replan_;
    goal.planning_options.planning_scene_diff.is_diff = true;
    goal.planning_options.planning_scene_diff.robot_state.is_diff = true;
    return goal;
  }

  static moveit_msgs::ExecuteTrajectoryGoal execution(const moveit_msgs::RobotTrajectory& trajectory)
  {
    moveit_msgs::ExecuteTrajectoryGoal goal;
    goal.trajectory = trajectory;
    return goal;
  }

  moveit_msgs::Constraints jointTarget() const
  {
    moveit_msgs::Constraints constraints;
    for (const auto& joint : joints_) {
      moveit_msgs::JointConstraint constraint;
      constraint.joint_name = joint.first;
      constraint.position = joint.second;
      constraint.tolerance_above = constraint.tolerance_below = joint_tolerance_;
      constraint.weight = 1.0;
      constraints.joint_constraints.push_back(constraint);
    }
    return constraints;
  }

  void fillJoints()
  {
    const auto state = getCurrentState();
    if (state) {
      for (const std::string& name : getVariableNames()) joints_[name] = state->getVariablePosition(name);
    }
    hasJointTarget_ = static_cast<bool>(state);
  }

  void usePose()
  {
    pose_ = moveit_msgs::Constraints();
    isJointTarget_ = false;
  }

  void addPosition(const std::string& frame, const geometry_msgs::Point& point, const std::string& link)
  {
    moveit_msgs::PositionConstraint constraint;
    constraint.header.frame_id = frame;
    constraint.link_name = link.empty() ? tip_ : link;
    shape_msgs::SolidPrimitive sphere;
    sphere.type = shape_msgs::SolidPrimitive::SPHERE;
    sphere.dimensions = {position_tolerance_};
    geometry_msgs::Pose centre;
    centre.position = point;
    centre.orientation.w = 1.0;
    constraint.constraint_region.primitives = {sphere};
    constraint.constraint_region.primitive_poses = {centre};
    constraint.weight = 1.0;
    pose_.position_constraints = {constraint};
  }

  void addOrientation(const std::string& frame, const geometry_msgs::Quaternion& turn,
                      const std::string& link)
  {
    moveit_msgs::OrientationConstraint constraint;
    constraint.header.frame_id = frame;
    constraint.link_name = link.empty() ? tip_ : link;
    constraint.orientation = turn;
    constraint.absolute_x_axis_tolerance = orientation_tolerance_;
    constraint.absolute_y_axis_tolerance = orientation_tolerance_;
    constraint.absolute_z_axis_tolerance = orientation_tolerance_;
    constraint.weight = 1.0;
    pose_.orientation_constraints = {constraint};
  }

  static moveit_msgs::RobotState current()
  {
    moveit_msgs::RobotState state;
    state.is_diff = true;
    return state;
  }

  void heard(const sensor_msgs::JointState& state)
  {
    std::lock_guard<std::mutex> lock(mutex_);
    for (std::size_t i = 0; i < state.position.size(); ++i) heard_[state.name[i]] = state.position[i];
    stamp_ = state.header.stamp;
  }

  // Whether a state has come that is not older than this call, which waits for one.
  bool hasState(double seconds) const
  {
    const ros::Time now = ros::Time::now();
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds + 9.0);
    while (node_.ok() && std::chrono::steady_clock::now() < until) {
      {
        std::lock_guard<std::mutex> lock(mutex_);
        if (!heard_.empty() && stamp_ >= now) return true;
      }
      if (ros::Time::now() - now > ros::Duration(seconds)) return false;
      ros::WallDuration(0.002).sleep();
    }
    return false;
  }

  ros::NodeHandle node_;
  actionlib::SimpleActionClient<moveit_msgs::MoveGroupAction> move_;
  actionlib::SimpleActionClient<moveit_msgs::ExecuteTrajectoryAction> execute_;
  ros::Publisher attached_, stop_;
  ros::Subscriber states_;
  mutable ros::ServiceClient cartesian_, forward_;
  moveit::core::RobotModelConstPtr model_;
  const moveit::core::JointModelGroup* group_ = nullptr;
  mutable std::vector<std::string> names_;
  std::string tip_, frame_, planner_, pipeline_;
  double time_ = 5.0, velocity_ = 0.1, acceleration_ = 0.1;
  double joint_tolerance_ = 1e-4, position_tolerance_ = 1e-4, orientation_tolerance_ = 1e-3;
  unsigned int attempts_ = 1;
  bool replan_ = false, look_ = false, isJointTarget_ = true, hasJointTarget_ = false;
  moveit_msgs::RobotState start_ = current();
  moveit_msgs::Constraints pose_, path_;
  std::map<std::string, double> joints_;
  mutable std::mutex mutex_;
  std::map<std::string, double> heard_;
  ros::Time stamp_;
};

typedef std::shared_ptr<MoveGroupInterface> MoveGroupInterfacePtr;

}  // namespace planning_interface
}  // namespace moveit
