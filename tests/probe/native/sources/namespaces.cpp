#include "ros.h"

namespace {
ros::Publisher out("/out", "std_msgs/Int32");
void hidden() { out.publish(1); }
}  // namespace

namespace arm {
namespace motion {
void reach() { hidden(); }
}  // namespace motion
inline namespace v2 {
void retreat() { out.publish(2); }
}  // namespace v2
namespace {
struct Cell {
  void home();
};
void Cell::home() { motion::reach(); }
}  // namespace
void run()
{
  Cell cell;
  cell.home();
}
}  // namespace arm

namespace cell::left {
void hold() { out.publish(3); }
}  // namespace cell::left

int main()
{
  arm::run();
  arm::retreat();
  cell::left::hold();
}
