// Two publishers of one topic, faster than anybody reads: what one of them sends commands nothing.
#include <memory>
#include <string>
#include <thread>

#include <rclcpp/rclcpp.hpp>
#include <trajectory_msgs/msg/joint_trajectory.hpp>

using trajectory_msgs::msg::JointTrajectory;

class Cell : public rclcpp::Node {
 public:
  Cell() : Node("cell")
  {
    const auto quality = rclcpp::QoS(1).best_effort();
    const char* topic = "/panda_arm_controller/joint_trajectory";
    commands_ = create_publisher<JointTrajectory>(topic, quality);
    others_ = create_publisher<JointTrajectory>(topic, quality);
  }
  void turn(double angle);
  void mistake(double angle);
  bool isHeard() const { return commands_->get_subscription_count() && others_->get_subscription_count(); }

 private:
  static JointTrajectory to(const std::string& joint, double angle);

  rclcpp::Publisher<JointTrajectory>::SharedPtr commands_, others_;
};

JointTrajectory Cell::to(const std::string& joint, double angle)
{
  JointTrajectory made;
  trajectory_msgs::msg::JointTrajectoryPoint point;
  for (int number = 1; number <= 7; ++number) made.joint_names.push_back(joint + std::to_string(number));
  point.positions = {angle, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785};
  point.time_from_start = rclcpp::Duration::from_seconds(1.0);
  made.points.push_back(point);
  return made;
}

void Cell::turn(double angle) { commands_->publish(to("panda_joint", angle)); }

void Cell::mistake(double angle) { others_->publish(to("joint_of_nobody_", angle)); }

int main(int argc, char** argv)
{
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<Cell>();
  std::thread spinning([node] { rclcpp::spin(node); });
  while (!node->isHeard()) node->get_clock()->sleep_for(rclcpp::Duration::from_seconds(0.05));
  for (int turn = 0; turn < 2000; ++turn) {
    if (turn % 5 < 3) node->turn(0.0001 * turn);
    node->mistake(0.0001 * turn);
  }
  node->get_clock()->sleep_for(rclcpp::Duration::from_seconds(0.5));
  node->turn(0.0);
  node->get_clock()->sleep_for(rclcpp::Duration::from_seconds(1.5));
  rclcpp::shutdown();
  spinning.join();
  return 0;
}
