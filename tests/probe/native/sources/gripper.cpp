#include "gripper.h"

hand::Gripper::Gripper() : out_("/gripper", "std_msgs/Int32")
{
  move(0);
}

hand::Gripper::~Gripper()
{
  move(1);
}

namespace hand {
void Gripper::close()
{
  move(10);
}
}  // namespace hand

void hand::Gripper::move(int width)
{
  out_.publish(width);
}
