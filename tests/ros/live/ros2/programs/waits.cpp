// One motion, then callbacks alone: by an executor that spins, or by a loop that polls.
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include <rclcpp/rclcpp.hpp>
#include <trajectory_msgs/msg/joint_trajectory.hpp>

using trajectory_msgs::msg::JointTrajectory;

static void reach(rclcpp::Node &node, rclcpp::Publisher<JointTrajectory> &commands)
{
  JointTrajectory made;
  trajectory_msgs::msg::JointTrajectoryPoint point;
  for (int joint = 1; joint <= 7; ++joint)
    made.joint_names.push_back("panda_joint" + std::to_string(joint));
  point.positions = {0.1, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785};
  point.time_from_start = rclcpp::Duration::from_seconds(1.0);
  made.points.push_back(point);
  while (commands.get_subscription_count() == 0)
    node.get_clock()->sleep_for(rclcpp::Duration::from_seconds(0.05));
  commands.publish(made);
}

int main(int argc, char **argv)
{
  rclcpp::init(argc, argv);
  auto node = std::make_shared<rclcpp::Node>("waits");
  auto commands =
      node->create_publisher<JointTrajectory>("/panda_arm_controller/joint_trajectory", 10);
  int called = 0;
  auto timer = rclcpp::create_timer(node, node->get_clock(), rclcpp::Duration::from_seconds(0.5),
                                    [&called] { ++called; });
  reach(*node, *commands);
  if (argc > 1 && !std::strcmp(argv[1], "spin")) {
    rclcpp::spin(node);
    return 0;
  }
  rclcpp::Rate rate(20.0, node->get_clock());
  while (rclcpp::ok()) {
    rclcpp::spin_some(node);
    rate.sleep();
  }
  return 0;
}
