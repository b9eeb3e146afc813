// MoveIt's MoveGroupInterface for machines without MoveIt, of ROS 1 and of ROS 2: over the actions,
// services and parameters of move_group, header only. Given by `tracerisk headers`; what it lacks
// does not compile.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <moveit/move_group_interface/constraints.h>
#include <moveit/of_ros/of_ros.h>
#include <moveit/robot_state/robot_state.h>
#include <moveit/utils/moveit_error_code.h>

namespace moveit {
namespace planning_interface {

using moveit::core::MoveItErrorCode;

class MoveGroupInterface {
 public:
  typedef of_ros::Plan Plan;
  typedef of_ros::Options Options;

#if MOVEIT_OF_ROS == 1
  MoveGroupInterface(const std::string& group) : MoveGroupInterface(Options(group)) {}
  MoveGroupInterface(const Options& options)
      : MoveGroupInterface(of_ros::Node(options.node_handle_), options.group_name_, "")
  {
  }
#else
  MoveGroupInterface(const rclcpp::Node::SharedPtr& node, const std::string& group,
                     const std::shared_ptr<tf2_ros::Buffer>& = nullptr,
                     const rclcpp::Duration& = rclcpp::Duration::from_seconds(-1))
      : MoveGroupInterface(node, Options(group))
  {
  }
  MoveGroupInterface(const rclcpp::Node::SharedPtr& node, const Options& options,
                     const std::shared_ptr<tf2_ros::Buffer>& = nullptr,
                     const rclcpp::Duration& = rclcpp::Duration::from_seconds(-1))
      : MoveGroupInterface(of_ros::Node(node), options.group_name, options.move_group_namespace)
  {
  }
  const rclcpp::Node::SharedPtr& getNode() const { return node_.handle(); }
#endif
  MoveGroupInterface(const MoveGroupInterface&) = delete;
  MoveGroupInterface& operator=(const MoveGroupInterface&) = delete;

  // The robot and its groups.
  const std::string& getName() const { return group_->getName(); }
  const std::vector<std::string>& getJointNames() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getJoints() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getActiveJoints() const { return group_->getVariableNames(); }
  const std::vector<std::string>& getVariableNames() const { return group_->getVariableNames(); }
  unsigned int getVariableCount() const { return getVariableNames().size(); }
  const std::vector<std::string>& getLinkNames() const { return group_->getLinkModelNames(); }
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
  const std::string& getPlannerId() const { return planner_; }
  const std::string& getPlanningPipelineId() const { return pipeline_; }
  void setMaxVelocityScalingFactor(double value) { velocity_ = factor("velocity", value); }
  void setMaxAccelerationScalingFactor(double value) { acceleration_ = factor("acceleration", value); }
  double getMaxVelocityScalingFactor() const { return velocity_; }
  double getMaxAccelerationScalingFactor() const { return acceleration_; }
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
  double getGoalJointTolerance() const { return joint_tolerance_; }
  double getGoalPositionTolerance() const { return position_tolerance_; }
  double getGoalOrientationTolerance() const { return orientation_tolerance_; }
  void setPathConstraints(const of_ros::moveit_msg::Constraints& constraints) { path_ = constraints; }
  void clearPathConstraints() { path_ = of_ros::moveit_msg::Constraints(); }
  void setStartStateToCurrentState() { start_ = current(); }
  void setStartState(const of_ros::moveit_msg::RobotState& state) { start_ = state; }
  void setStartState(const moveit::core::RobotState& state)
  {
    start_ = of_ros::moveit_msg::RobotState();
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
      node_.error("The requested named target '" + name + "' does not exist");
      return false;
    }
    setJointValueTarget(getNamedTargetValues(name));
    return true;
  }
  // Joints that are not named keep their target. Return whether all are within their limits.
  bool setJointValueTarget(const std::map<std::string, double>& values)
  {
    bool isWithin = isJointTarget_ = true;
    for (auto& joint : joints_) {
      const auto value = values.find(joint.first);
      if (value != values.end()) joint.second = value->second;
      isWithin = isWithin && model_->isWithin(joint.first, joint.second, joint_tolerance_);
    }
    return isWithin;
  }
  bool setJointValueTarget(const std::vector<double>& values)
  {
    return values.size() == getVariableNames().size() && setJointValueTarget(getVariableNames(), values);
  }
  bool setJointValueTarget(const std::vector<std::string>& joints, const std::vector<double>& values)
  {
    std::map<std::string, double> named;
    for (std::size_t i = 0; i < joints.size() && i < values.size(); ++i) named[joints[i]] = values[i];
    return setJointValueTarget(named);
  }
  bool setJointValueTarget(const of_ros::sensor_msg::JointState& state)
  {
    return setJointValueTarget(state.name, state.position);
  }
  bool setJointValueTarget(const moveit::core::RobotState& state)
  {
    std::vector<double> values;
    state.copyJointGroupPositions(group_, values);
    return setJointValueTarget(values);
  }
  bool setJointValueTarget(const std::string& joint, double value)
  {
    return setJointValueTarget(std::map<std::string, double>{{joint, value}});
  }
  bool setPoseTarget(const of_ros::geometry_msg::PoseStamped& pose, const std::string& link = "")
  {
    const std::string& frame = pose.header.frame_id.empty() ? frame_ : pose.header.frame_id;
    usePose();
    pose_.position_constraints = {
        positionConstraint(frame, pose.pose.position, carried(link), position_tolerance_)};
    pose_.orientation_constraints = {
        orientationConstraint(frame, pose.pose.orientation, carried(link), orientation_tolerance_)};
    return true;
  }
  bool setPoseTarget(const of_ros::geometry_msg::Pose& pose, const std::string& link = "")
  {
    of_ros::geometry_msg::PoseStamped stamped;
    stamped.pose = pose;
    return setPoseTarget(stamped, link);
  }
  bool setPositionTarget(double x, double y, double z, const std::string& link = "")
  {
    of_ros::geometry_msg::Point point;
    point.x = x, point.y = y, point.z = z;
    usePose();
    pose_.position_constraints = {positionConstraint(frame_, point, carried(link), position_tolerance_)};
    return true;
  }
  bool setOrientationTarget(double x, double y, double z, double w, const std::string& link = "")
  {
    of_ros::geometry_msg::Quaternion turn;
    turn.x = x, turn.y = y, turn.z = z, turn.w = w;
    usePose();
    pose_.orientation_constraints = {
        orientationConstraint(frame_, turn, carried(link), orientation_tolerance_)};
    return true;
  }
  bool setRPYTarget(double roll, double pitch, double yaw, const std::string& link = "")
  {
    const double a = std::cos(roll / 2), b = std::cos(pitch / 2), c = std::cos(yaw / 2);
    const double x = std::sin(roll / 2), y = std::sin(pitch / 2), z = std::sin(yaw / 2);
    return setOrientationTarget(x * b * c - a * y * z, a * y * c + x * b * z, a * b * z - x * y * c,
                                a * b * c + x * y * z, link);
  }
  void clearPoseTargets() { pose_ = of_ros::moveit_msg::Constraints(); }
  void clearPoseTarget(const std::string& = "") { clearPoseTargets(); }

  // Planning and moving.
  MoveItErrorCode plan(Plan& plan)
  {
    const auto result = move_.result(request(true));
    if (code(result)) plan.set(*result);
    return code(result);
  }
  MoveItErrorCode move() { return code(move_.result(request(false))); }
  MoveItErrorCode asyncMove() { return move_.send(request(false)), MoveItErrorCode::SUCCESS; }
  MoveItErrorCode execute(const Plan& plan) { return execute(plan.planned()); }
  MoveItErrorCode asyncExecute(const Plan& plan) { return asyncExecute(plan.planned()); }
  MoveItErrorCode execute(const of_ros::moveit_msg::RobotTrajectory& trajectory)
  {
    return code(execute_.result(execution(trajectory)));
  }
  MoveItErrorCode asyncExecute(const of_ros::moveit_msg::RobotTrajectory& trajectory)
  {
    return execute_.send(execution(trajectory)), MoveItErrorCode::SUCCESS;
  }
  double computeCartesianPath(const std::vector<of_ros::geometry_msg::Pose>& waypoints, double step,
                              double jump, of_ros::moveit_msg::RobotTrajectory& trajectory,
                              bool avoid = true, of_ros::moveit_msg::MoveItErrorCodes* code = nullptr)
  {
    return computeCartesianPath(waypoints, step, jump, trajectory, of_ros::moveit_msg::Constraints(), avoid,
                                code);
  }
  double computeCartesianPath(const std::vector<of_ros::geometry_msg::Pose>& waypoints, double step,
                              double jump, of_ros::moveit_msg::RobotTrajectory& trajectory,
                              const of_ros::moveit_msg::Constraints& path, bool avoid = true,
                              of_ros::moveit_msg::MoveItErrorCodes* code = nullptr)
  {
    of_ros::moveit_srv::GetCartesianPath::Request request;
    of_ros::moveit_srv::GetCartesianPath::Response response;
    request.start_state = start_;
    request.group_name = getName();
    request.header.frame_id = frame_;
    request.header.stamp = node_.now();
    request.waypoints = waypoints;
    request.max_step = step;
    request.jump_threshold = jump;
    request.path_constraints = path;
    request.avoid_collisions = avoid;
    request.link_name = tip_;
    const bool isCalled = cartesian_(request, response);
    if (code != nullptr) *code = response.error_code;
    if (!isCalled || response.error_code.val != MoveItErrorCode::SUCCESS) return -1.0;
    trajectory = response.solution;
    return response.fraction;
  }
#if MOVEIT_OF_ROS == 2
  double computeCartesianPath(const std::vector<of_ros::geometry_msg::Pose>& waypoints, double step,
                              of_ros::moveit_msg::RobotTrajectory& trajectory, bool avoid = true,
                              of_ros::moveit_msg::MoveItErrorCodes* code = nullptr)
  {
    return computeCartesianPath(waypoints, step, 0.0, trajectory, avoid, code);
  }
  double computeCartesianPath(const std::vector<of_ros::geometry_msg::Pose>& waypoints, double step,
                              of_ros::moveit_msg::RobotTrajectory& trajectory,
                              const of_ros::moveit_msg::Constraints& path, bool avoid = true,
                              of_ros::moveit_msg::MoveItErrorCodes* code = nullptr)
  {
    return computeCartesianPath(waypoints, step, 0.0, trajectory, path, avoid, code);
  }
#endif
  void stop()
  {
    of_ros::std_msg::String event;
    event.data = "stop";
    event_(event);
  }

  // Where the robot is.
  bool startStateMonitor(double seconds = 1.0) { return hasState(seconds); }
  moveit::core::RobotStatePtr getCurrentState(double seconds = 1.0) const
  {
    if (!hasState(seconds)) {
      node_.error("Failed to fetch current robot state");
      return nullptr;
    }
    std::lock_guard<std::mutex> lock(heard_->mutex);
    auto state = std::make_shared<moveit::core::RobotState>(model_);
    for (const auto& one : heard_->positions) state->setVariablePosition(one.first, one.second);
    return state;
  }
  std::vector<double> getCurrentJointValues() const
  {
    std::vector<double> values;
    if (const auto state = getCurrentState()) state->copyJointGroupPositions(group_, values);
    return values;
  }
  of_ros::geometry_msg::PoseStamped getCurrentPose(const std::string& link = "") const
  {
    of_ros::moveit_srv::GetPositionFK::Request request;
    of_ros::moveit_srv::GetPositionFK::Response response;
    request.header.frame_id = getPlanningFrame();
    request.fk_link_names = {carried(link)};
    if (const auto state = getCurrentState()) request.robot_state.joint_state = state->message();
    if (!forward_(request, response) || response.pose_stamped.empty()) {
      node_.error("no pose of " + request.fk_link_names[0] + " is known");
      return of_ros::geometry_msg::PoseStamped();
    }
    return response.pose_stamped[0];
  }

  // Objects in the hand.
  bool attachObject(const std::string& object, const std::string& link = "",
                    const std::vector<std::string>& touched = {})
  {
    of_ros::moveit_msg::AttachedCollisionObject attached;
    attached.link_name = carried(link);
    attached.object.id = object;
    attached.object.operation = of_ros::moveit_msg::CollisionObject::ADD;
    attached.touch_links = touched.empty() ? std::vector<std::string>{attached.link_name} : touched;
    attach_(attached);
    return true;
  }
  bool detachObject(const std::string& object = "")
  {
    of_ros::moveit_msg::AttachedCollisionObject attached;
    attached.object.id = object;
    attached.object.operation = of_ros::moveit_msg::CollisionObject::REMOVE;
    attach_(attached);
    return true;
  }

 private:
  // Where the joints are, as it was heard last.
  struct Heard {
    std::mutex mutex;
    std::map<std::string, double> positions;
    std::int64_t stamp = 0;
  };

  MoveGroupInterface(const of_ros::Node& node, const std::string& group, const std::string& space)
      : node_(node),
        model_(moveit::core::RobotModel::get(node_)),
        group_(existing(group)),
        move_(node_, inside(space)),
        execute_(node_, inside(space)),
        attach_(node_.publisher<of_ros::moveit_msg::AttachedCollisionObject>(
            inside(space) + "attached_collision_object")),
        event_(node_.publisher<of_ros::std_msg::String>(inside(space) + "trajectory_execution_event")),
        cartesian_(node_.client<of_ros::moveit_srv::GetCartesianPath>(
            inside(space) + "compute_cartesian_path")),
        forward_(node_.client<of_ros::moveit_srv::GetPositionFK>(inside(space) + "compute_fk")),
        tip_(model_->tip(group)),
        frame_(model_->getModelFrame()),
        velocity_(usual("velocity")),
        acceleration_(usual("acceleration"))
  {
    for (const std::string& joint : getVariableNames()) joints_[joint] = model_->usual(joint);
    const auto heard = heard_;
    states_ = node_.subscription<of_ros::sensor_msg::JointState>(
        "joint_states", [heard](const of_ros::sensor_msg::JointState& state) {
          std::lock_guard<std::mutex> lock(heard->mutex);
          for (std::size_t i = 0; i < state.position.size(); ++i) {
            heard->positions[state.name[i]] = state.position[i];
          }
          heard->stamp = of_ros::nanoseconds(state.header.stamp);
        });
  }

  static std::string inside(const std::string& space) { return space.empty() ? "" : space + "/"; }

  const moveit::core::JointModelGroup* existing(const std::string& name) const
  {
    const auto* group = model_->getJointModelGroup(name);
    if (group != nullptr) return group;
    const std::string error = "Group '" + name + "' was not found.";
    node_.fatal(error);
    throw std::runtime_error(error);
  }

  double usual(const std::string& of) const
  {
    return node_.number("robot_description_planning", "default_" + of + "_scaling_factor", 0.1);
  }
  double factor(const std::string& of, double value) const
  {
    return value > 1.0 ? 1.0 : value > 0.0 ? value : usual(of);
  }

  template <typename Kind>
  static MoveItErrorCode code(const std::shared_ptr<Kind>& result)
  {
    return result ? MoveItErrorCode(result->error_code) : MoveItErrorCode::FAILURE;
  }

  of_ros::MoveGroup::Goal request(bool isPlanOnly) const
  {
    of_ros::MoveGroup::Goal goal;
    of_ros::moveit_msg::MotionPlanRequest& request = goal.request;
    request.group_name = getName();
    request.start_state = start_;
    request.num_planning_attempts = attempts_;
    request.allowed_planning_time = time_;
    request.planner_id = planner_;
    request.pipeline_id = pipeline_;
    request.max_velocity_scaling_factor = velocity_;
    request.max_acceleration_scaling_factor = acceleration_;
    request.path_constraints = path_;
    request.goal_constraints = {isJointTarget_ ? jointConstraints(joints_, joint_tolerance_) : pose_};
    goal.planning_options.plan_only = isPlanOnly;
    goal.planning_options.look_around = look_;
    goal.planning_options.replan = replan_;
    goal.planning_options.planning_scene_diff.is_diff = true;
    goal.planning_options.planning_scene_diff.robot_state.is_diff = true;
    return goal;
  }

  static of_ros::ExecuteTrajectory::Goal execution(const of_ros::moveit_msg::RobotTrajectory& trajectory)
  {
    of_ros::ExecuteTrajectory::Goal goal;
    goal.trajectory = trajectory;
    return goal;
  }

  const std::string& carried(const std::string& link) const { return link.empty() ? tip_ : link; }

  void usePose()
  {
    pose_ = of_ros::moveit_msg::Constraints();
    isJointTarget_ = false;
  }

  static of_ros::moveit_msg::RobotState current()
  {
    of_ros::moveit_msg::RobotState state;
    state.is_diff = true;
    return state;
  }

  // Whether a state has come that is not older than this call, which waits for one.
  bool hasState(double seconds) const
  {
    const std::int64_t now = of_ros::nanoseconds(node_.now());
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds + 9.0);
    while (node_.ok() && std::chrono::steady_clock::now() < until) {
      {
        std::lock_guard<std::mutex> lock(heard_->mutex);
        if (!heard_->positions.empty() && heard_->stamp >= now) return true;
      }
      if (of_ros::nanoseconds(node_.now()) - now > static_cast<std::int64_t>(seconds * 1e9)) return false;
      node_.pause();
    }
    return false;
  }

  of_ros::Node node_;
  moveit::core::RobotModelConstPtr model_;
  const moveit::core::JointModelGroup* group_;
  of_ros::Action<of_ros::MoveGroup> move_;
  of_ros::Action<of_ros::ExecuteTrajectory> execute_;
  std::function<void(const of_ros::moveit_msg::AttachedCollisionObject&)> attach_;
  std::function<void(const of_ros::std_msg::String&)> event_;
  of_ros::Client<of_ros::moveit_srv::GetCartesianPath> cartesian_;
  of_ros::Client<of_ros::moveit_srv::GetPositionFK> forward_;
  mutable std::vector<std::string> names_;
  std::string tip_, frame_, planner_, pipeline_;
  double time_ = 5.0, velocity_, acceleration_;
  double joint_tolerance_ = 1e-4, position_tolerance_ = 1e-4, orientation_tolerance_ = 1e-3;
  unsigned int attempts_ = 1;
  bool replan_ = false, look_ = false, isJointTarget_ = true;
  of_ros::moveit_msg::RobotState start_ = current();
  of_ros::moveit_msg::Constraints pose_, path_;
  std::map<std::string, double> joints_;
  const std::shared_ptr<Heard> heard_ = std::make_shared<Heard>();
  std::shared_ptr<void> states_;
};

typedef std::shared_ptr<MoveGroupInterface> MoveGroupInterfacePtr;

}  // namespace planning_interface
}  // namespace moveit
