// What the interfaces of MoveIt need of ROS 2: names of messages, and what a node exchanges.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <geometry_msgs/msg/pose_stamped.hpp>
#include <moveit_msgs/action/execute_trajectory.hpp>
#include <moveit_msgs/action/move_group.hpp>
#include <moveit_msgs/msg/attached_collision_object.hpp>
#include <moveit_msgs/msg/collision_object.hpp>
#include <moveit_msgs/msg/move_it_error_codes.hpp>
#include <moveit_msgs/srv/apply_planning_scene.hpp>
#include <moveit_msgs/srv/get_cartesian_path.hpp>
#include <moveit_msgs/srv/get_planning_scene.hpp>
#include <moveit_msgs/srv/get_position_fk.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp/version.h>
#include <rclcpp_action/rclcpp_action.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <shape_msgs/msg/solid_primitive.hpp>
#include <std_msgs/msg/string.hpp>

#define MOVEIT_OF_ROS 2

namespace tf2_ros {
class Buffer;
}

namespace moveit {
namespace of_ros {

namespace geometry_msg = ::geometry_msgs::msg;
namespace moveit_msg = ::moveit_msgs::msg;
namespace moveit_srv = ::moveit_msgs::srv;
namespace sensor_msg = ::sensor_msgs::msg;
namespace shape_msg = ::shape_msgs::msg;
namespace std_msg = ::std_msgs::msg;

struct MoveGroup {
  typedef ::moveit_msgs::action::MoveGroup Action;
  typedef Action::Goal Goal;
  typedef Action::Result Result;
  static const char* name() { return "move_action"; }
};

struct ExecuteTrajectory {
  typedef ::moveit_msgs::action::ExecuteTrajectory Action;
  typedef Action::Goal Goal;
  typedef Action::Result Result;
  static const char* name() { return "execute_trajectory"; }
};

// Its names end in a sign in Humble, and do not in Jazzy.
struct Plan {
  moveit_msg::RobotState start_state;
  moveit_msg::RobotTrajectory trajectory;
  double planning_time = 0.0;
  moveit_msg::RobotState& start_state_ = start_state;
  moveit_msg::RobotTrajectory& trajectory_ = trajectory;
  double& planning_time_ = planning_time;

  Plan() = default;
  Plan(const Plan& other)
      : start_state(other.start_state), trajectory(other.trajectory), planning_time(other.planning_time)
  {
  }
  Plan& operator=(const Plan& other)
  {
    start_state = other.start_state, trajectory = other.trajectory;
    planning_time = other.planning_time;
    return *this;
  }
  void set(const MoveGroup::Result& result)
  {
    start_state = result.trajectory_start;
    trajectory = result.planned_trajectory;
    planning_time = result.planning_time;
  }
  const moveit_msg::RobotTrajectory& planned() const { return trajectory; }
};

struct Options {
  explicit Options(std::string group, std::string = "robot_description", std::string space = "")
      : group_name(std::move(group)), move_group_namespace(std::move(space))
  {
  }
  std::string group_name, move_group_namespace;
};

// What calls a service, and says whether it has answered.
template <typename Service>
using Client = std::function<bool(const typename Service::Request&, typename Service::Response&)>;

inline std::int64_t nanoseconds(const rclcpp::Time& time) { return time.nanoseconds(); }

// A node, and what it exchanges; a closure holds the publisher or client that it is of. As in MoveIt,
// answers are taken by a thread of its own, and what is subscribed to comes while the node spins.
class Node {
 public:
  explicit Node(const rclcpp::Node::SharedPtr& node)
      : node_(node),
        group_(node->create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, false)),
        executor_(std::make_shared<rclcpp::executors::SingleThreadedExecutor>())
  {
    executor_->add_callback_group(group_, node->get_node_base_interface());
    const auto executor = executor_;
    spinning_ = std::shared_ptr<std::thread>(new std::thread([executor] { executor->spin(); }),
                                             [executor](std::thread* thread) {
                                               executor->cancel();
                                               thread->join();
                                               delete thread;
                                             });
    while (rclcpp::ok() && !executor_->is_spinning()) pause();  // none is cancelled before it spins
  }
  explicit Node(const std::string& space = "") : Node(made(space)) {}

  bool ok() const { return rclcpp::ok(node_->get_node_base_interface()->get_context()); }
  rclcpp::Time now() const { return node_->now(); }
  void pause() const { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }
  void error(const std::string& text) const { RCLCPP_ERROR_STREAM(node_->get_logger(), text); }
  void fatal(const std::string& text) const { RCLCPP_FATAL_STREAM(node_->get_logger(), text); }

  double number(const std::string& space, const std::string& name, double otherwise) const
  {
    node_->get_parameter(space + "." + name, otherwise);
    return otherwise;
  }
  // Return a text that describes the robot: a parameter of the node, else what is published of its
  // name within 10 s; an empty one where there is none.
  std::string description(const std::string& name) const
  {
    std::string text;
    if (node_->get_parameter(name, text)) return text;
    const auto heard = std::make_shared<std::promise<std::string>>();
    const auto once = std::make_shared<std::once_flag>();
    rclcpp::SubscriptionOptions options;
    options.callback_group = group_;
    const auto subscription = node_->create_subscription<std_msg::String>(
        name, rclcpp::QoS(1).transient_local().reliable(),
        [heard, once](const std_msg::String& message) {
          std::call_once(*once, [&] { heard->set_value(message.data); });
        },
        options);
    auto future = heard->get_future();
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (ok() && std::chrono::steady_clock::now() < until) {
      if (is_ready(future)) return future.get();
    }
    return text;
  }

  template <typename Message>
  std::function<void(const Message&)> publisher(const std::string& topic)
  {
    const auto end = node_->create_publisher<Message>(topic, 1);
    return [end](const Message& message) { end->publish(message); };
  }
  template <typename Message>
  std::shared_ptr<void> subscription(const std::string& topic, std::function<void(const Message&)> heard)
  {
    return node_->create_subscription<Message>(topic, rclcpp::SystemDefaultsQoS(), heard);
  }
  template <typename Service>
  Client<Service> client(const std::string& name, bool waits = false)
  {
#if RCLCPP_VERSION_GTE(21, 0, 0)
    const auto end = node_->create_client<Service>(name, rclcpp::ServicesQoS(), group_);
#else
    const auto end = node_->create_client<Service>(name, rmw_qos_profile_services_default, group_);
#endif
    while (waits && ok() && !end->wait_for_service(std::chrono::milliseconds(100))) {
    }
    const Node node = *this;
    return [end, node](const typename Service::Request& request, typename Service::Response& response) {
      if (!end->wait_for_service(std::chrono::seconds(5))) return false;
      auto future = end->async_send_request(std::make_shared<typename Service::Request>(request)).share();
      while (node.ok() && !is_ready(future)) {
      }
      if (!is_ready(future)) return false;
      response = *future.get();
      return true;
    };
  }

  const rclcpp::Node::SharedPtr& handle() const { return node_; }
  const rclcpp::CallbackGroup::SharedPtr& group() const { return group_; }

  template <typename Future>
  static bool is_ready(const Future& future)
  {
    return future.wait_for(std::chrono::milliseconds(1)) == std::future_status::ready;
  }

 private:
  static rclcpp::Node::SharedPtr made(const std::string& space)
  {
    static int number = 0;
    const std::string name = "planning_scene_interface_" + std::to_string(++number);
    rclcpp::NodeOptions options;
    options.arguments({"--ros-args", "-r", "__node:=" + name});  // one that is renamed is one of several
    return rclcpp::Node::make_shared(name, space, options);
  }

  rclcpp::Node::SharedPtr node_;
  rclcpp::CallbackGroup::SharedPtr group_;
  std::shared_ptr<rclcpp::executors::SingleThreadedExecutor> executor_;
  std::shared_ptr<std::thread> spinning_;  // ends with the last copy
};

template <typename Kind>
class Action {
 public:
  typedef rclcpp_action::Client<typename Kind::Action> Client;

  Action(const Node& node, const std::string& space)
      : node_(node),
        client_(rclcpp_action::create_client<typename Kind::Action>(
            node.handle(), space + Kind::name(), node.group()))
  {
    while (node.ok() && !client_->wait_for_action_server(std::chrono::milliseconds(100))) {
    }
  }
  void send(const typename Kind::Goal& goal) { client_->async_send_goal(goal); }
  // Send a goal and wait for its result; return an empty pointer where there is none.
  std::shared_ptr<typename Kind::Result> result(const typename Kind::Goal& goal)
  {
    typedef rclcpp_action::ClientGoalHandle<typename Kind::Action> Handle;
    const auto done = std::make_shared<std::promise<std::shared_ptr<typename Kind::Result>>>();
    typename Client::SendGoalOptions options;
    options.goal_response_callback = [done](const typename Handle::SharedPtr& handle) {
      if (!handle) done->set_value(nullptr);
    };
    options.result_callback = [done](const typename Handle::WrappedResult& result) {
      done->set_value(result.result);
    };
    auto future = done->get_future();
    client_->async_send_goal(goal, options);
    while (node_.ok() && !Node::is_ready(future)) {
    }
    return Node::is_ready(future) ? future.get() : nullptr;
  }

 private:
  Node node_;
  typename Client::SharedPtr client_;
};

}  // namespace of_ros
}  // namespace moveit
