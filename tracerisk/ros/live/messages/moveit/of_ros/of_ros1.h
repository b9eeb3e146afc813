// What the interfaces of MoveIt need of ROS 1: names of messages, and what a node exchanges.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <geometry_msgs/PoseStamped.h>
#include <moveit_msgs/ApplyPlanningScene.h>
#include <moveit_msgs/AttachedCollisionObject.h>
#include <moveit_msgs/CollisionObject.h>
#include <moveit_msgs/ExecuteTrajectoryAction.h>
#include <moveit_msgs/GetCartesianPath.h>
#include <moveit_msgs/GetPlanningScene.h>
#include <moveit_msgs/GetPositionFK.h>
#include <moveit_msgs/MoveGroupAction.h>
#include <moveit_msgs/MoveItErrorCodes.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <shape_msgs/SolidPrimitive.h>
#include <std_msgs/String.h>

#define MOVEIT_OF_ROS 1

namespace moveit {
namespace of_ros {

namespace geometry_msg = ::geometry_msgs;
namespace moveit_msg = ::moveit_msgs;
namespace moveit_srv = ::moveit_msgs;
namespace sensor_msg = ::sensor_msgs;
namespace shape_msg = ::shape_msgs;
namespace std_msg = ::std_msgs;

struct MoveGroup {
  typedef ::moveit_msgs::MoveGroupAction Action;
  typedef ::moveit_msgs::MoveGroupGoal Goal;
  typedef ::moveit_msgs::MoveGroupResult Result;
  static const char* name() { return "move_group"; }
};

struct ExecuteTrajectory {
  typedef ::moveit_msgs::ExecuteTrajectoryAction Action;
  typedef ::moveit_msgs::ExecuteTrajectoryGoal Goal;
  typedef ::moveit_msgs::ExecuteTrajectoryResult Result;
  static const char* name() { return "execute_trajectory"; }
};

struct Plan {
  ::moveit_msgs::RobotState start_state_;
  ::moveit_msgs::RobotTrajectory trajectory_;
  double planning_time_ = 0.0;
  void set(const MoveGroup::Result& result)
  {
    start_state_ = result.trajectory_start;
    trajectory_ = result.planned_trajectory;
    planning_time_ = result.planning_time;
  }
  const ::moveit_msgs::RobotTrajectory& planned() const { return trajectory_; }
};

struct Options {
  explicit Options(std::string group, std::string = "robot_description",
                   const ros::NodeHandle& node = ros::NodeHandle())
      : group_name_(std::move(group)), node_handle_(node)
  {
  }
  std::string group_name_;
  ros::NodeHandle node_handle_;
};

// What calls a service, and says whether it has answered.
template <typename Service>
using Client = std::function<bool(const typename Service::Request&, typename Service::Response&)>;

inline std::int64_t nanoseconds(const ros::Time& time) { return static_cast<std::int64_t>(time.toNSec()); }

// A node, and what it exchanges; a closure holds the publisher or client that it is of.
class Node {
 public:
  explicit Node(const ros::NodeHandle& node) : node_(node) {}
  explicit Node(const std::string& space = "") : node_(space) {}

  bool ok() const { return node_.ok(); }
  ros::Time now() const { return ros::Time::now(); }
  void pause() const { ros::WallDuration(0.002).sleep(); }
  static void error(const std::string& text) { ROS_ERROR_STREAM(text); }
  static void fatal(const std::string& text) { ROS_FATAL_STREAM(text); }

  double number(const std::string& space, const std::string& name, double otherwise) const
  {
    return node_.param(space + "/" + name, otherwise);
  }
  // Return a text that describes the robot; an empty one where there is none.
  std::string description(const std::string& name) const
  {
    std::string text;
    ros::param::get(name, text);
    return text;
  }

  template <typename Message>
  std::function<void(const Message&)> publisher(const std::string& topic)
  {
    const ros::Publisher end = node_.advertise<Message>(topic, 1);
    return [end](const Message& message) { end.publish(message); };
  }
  template <typename Message>
  std::shared_ptr<void> subscription(const std::string& topic, std::function<void(const Message&)> heard)
  {
    const auto called = [heard](const boost::shared_ptr<const Message>& message) { heard(*message); };
    return std::make_shared<ros::Subscriber>(node_.subscribe<Message>(topic, 100, called));
  }
  template <typename Service>
  Client<Service> client(const std::string& name, bool waits = false)
  {
    ros::ServiceClient end = node_.serviceClient<Service>(name);
    if (waits) end.waitForExistence();
    return [end](typename Service::Request request, typename Service::Response& response) mutable {
      return end.call(request, response);
    };
  }

  ros::NodeHandle& handle() { return node_; }

 private:
  ros::NodeHandle node_;
};

// A client of an action. As in MoveIt the user's own spinner takes the results: without one, this
// waits for ever.
template <typename Kind>
class Action {
 public:
  Action(const Node& node, const std::string& space)
      : node_(node), client_(node_.handle(), space + Kind::name(), false)
  {
    auto* queue = dynamic_cast<ros::CallbackQueue*>(node_.handle().getCallbackQueue());
    while (node.ok() && !client_.isServerConnected()) {
      ros::WallDuration(0.005).sleep();
      if (queue != nullptr) queue->callAvailable();
    }
  }
  void send(const typename Kind::Goal& goal) { client_.sendGoal(goal); }
  // Send a goal and wait for its result; return an empty pointer where there is none.
  std::shared_ptr<typename Kind::Result> result(const typename Kind::Goal& goal)
  {
    send(goal);
    while (node_.ok() && !client_.getState().isDone()) node_.pause();
    const auto result = client_.getResult();
    return result ? std::make_shared<typename Kind::Result>(*result) : nullptr;
  }

 private:
  Node node_;
  actionlib::SimpleActionClient<typename Kind::Action> client_;
};

}  // namespace of_ros
}  // namespace moveit
