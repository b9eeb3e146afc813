#pragma once
#include "ros.h"

namespace hand {
class Gripper {
 public:
  Gripper();
  ~Gripper();
  void open() { move(80); }
  void close();

 private:
  void move(int width);
  ros::Publisher out_;
};
}  // namespace hand
