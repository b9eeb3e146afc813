// Set-points on a topic, goals, a timer of the node's clock, a parameter, a service of its own, and
// what a bad end needs: a logged error, a function that never ran, a code.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <control_msgs/action/follow_joint_trajectory.hpp>
#include <control_msgs/action/gripper_command.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_action/rclcpp_action.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <trajectory_msgs/msg/joint_trajectory.hpp>

namespace cell {
using Follow = control_msgs::action::FollowJointTrajectory;
using Grip = control_msgs::action::GripperCommand;
using std_srvs::srv::SetBool;
using trajectory_msgs::msg::JointTrajectory;

class Cell : public rclcpp::Node {
 public:
  Cell();
  bool begin();
  void reach();
  void back();
  void grip();
  void park() { arm_->async_send_goal(Follow::Goal()); }
  double turned() const { return turned_; }

 private:
  JointTrajectory to(double angle) const;
  void wait(double seconds) { get_clock()->sleep_for(rclcpp::Duration::from_seconds(seconds)); }
  template <typename Future>
  auto got(Future future)
  {
    while (future.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) {
    }
    return future.get();
  }

  std::atomic<double> turned_{NAN};
  rclcpp_action::Client<Follow>::SharedPtr arm_;
  rclcpp_action::Client<Grip>::SharedPtr hand_;
  rclcpp::Publisher<JointTrajectory>::SharedPtr commands_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr states_;
  rclcpp::Service<SetBool>::SharedPtr switch_;
  rclcpp::Client<SetBool>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr once_;
  std::promise<bool> gripped_;
};

Cell::Cell() : Node("cell")
{
  arm_ = rclcpp_action::create_client<Follow>(
      this, "/panda_arm_controller/follow_joint_trajectory");
  hand_ = rclcpp_action::create_client<Grip>(this, "/panda_hand_controller/gripper_cmd");
  commands_ = create_publisher<JointTrajectory>("/panda_arm_controller/joint_trajectory", 10);
  states_ = create_subscription<sensor_msgs::msg::JointState>(
      "/joint_states", 10, [this](const sensor_msgs::msg::JointState &state) {
        for (size_t at = 0; at < state.name.size(); ++at)
          if (state.name[at] == "panda_joint1") turned_ = state.position[at];
      });
  switch_ = create_service<SetBool>(
      "~/switch", [](SetBool::Request::SharedPtr asked, SetBool::Response::SharedPtr answer) {
        answer->message = asked->data ? "on" : "off";
      });
  client_ = create_client<SetBool>("~/switch");
  declare_parameter("angle", 0.1);
}

bool Cell::begin()
{
  if (!client_->wait_for_service(std::chrono::seconds(20))) return false;
  auto asked = std::make_shared<SetBool::Request>();
  asked->data = true;
  std::printf("> switched %s\n", got(client_->async_send_request(asked))->message.c_str());
  if (!arm_->wait_for_action_server(std::chrono::seconds(20))) return false;
  if (!hand_->wait_for_action_server(std::chrono::seconds(20))) return false;
  while (commands_->get_subscription_count() == 0 || std::isnan(turned_)) wait(0.05);
  return true;
}

JointTrajectory Cell::to(double angle) const
{
  JointTrajectory made;
  const std::vector<double> rest = {-0.785, 0.0, -2.356, 0.0, 1.571, 0.785};
  trajectory_msgs::msg::JointTrajectoryPoint point;
  for (int joint = 1; joint <= 7; ++joint)
    made.joint_names.push_back("panda_joint" + std::to_string(joint));
  point.positions = {angle};
  point.positions.insert(point.positions.end(), rest.begin(), rest.end());
  point.time_from_start = rclcpp::Duration::from_seconds(1.0);
  made.points.push_back(point);
  return made;
}

void Cell::reach()
{
  commands_->publish(to(get_parameter("angle").as_double()));
  wait(1.5);
  std::printf("> reached %.2f\n", turned());
}

void Cell::back()
{
  Follow::Goal goal;
  goal.trajectory = to(0.0);
  auto handle = got(arm_->async_send_goal(goal));
  auto result = got(arm_->async_get_result(handle));
  wait(0.1);
  std::printf("> back %d %.2f\n", static_cast<int>(result.code), std::abs(turned()));
}

void Cell::grip()
{
  once_ = rclcpp::create_timer(this, get_clock(), std::chrono::milliseconds(100), [this] {
    once_->cancel();
    Grip::Goal goal;
    goal.command.position = 0.01;
    rclcpp_action::Client<Grip>::SendGoalOptions options;
    options.result_callback = [this](const auto &) { gripped_.set_value(true); };
    hand_->async_send_goal(goal, options);
  });
  std::printf("> gripped %d\n", got(gripped_.get_future()));
}
}  // namespace cell

int main(int argc, char **argv)
{
  rclcpp::init(argc, argv);
  auto node = std::make_shared<cell::Cell>();
  const bool isTimeThere = node->now().seconds() > 1767225599;
  std::thread spinning([node] { rclcpp::spin(node); });
  if (!node->begin()) return 2;
  node->reach();
  node->back();
  node->grip();
  std::printf("> simulated %d\n", isTimeThere && node->now().seconds() < 1767225700);
  RCLCPP_ERROR(node->get_logger(), "lost a part\nbehind the rack");
  std::printf("> args %d\n", argc);
  node->get_clock()->sleep_for(rclcpp::Duration::from_seconds(0.1));
  rclcpp::shutdown();
  spinning.join();
  return 3;
}
