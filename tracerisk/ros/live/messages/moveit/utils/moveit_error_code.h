// MoveIt's MoveItErrorCode for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <moveit/of_ros/of_ros.h>

namespace moveit {
namespace core {

class MoveItErrorCode : public of_ros::moveit_msg::MoveItErrorCodes {
 public:
  MoveItErrorCode(int code = 0) { val = code; }
  MoveItErrorCode(const of_ros::moveit_msg::MoveItErrorCodes& code) { val = code.val; }
  explicit operator bool() const { return val == SUCCESS; }
  bool operator==(int code) const { return val == code; }
  bool operator!=(int code) const { return val != code; }
};

}  // namespace core
}  // namespace moveit
