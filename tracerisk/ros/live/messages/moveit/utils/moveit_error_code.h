// MoveIt's MoveItErrorCode for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <moveit_msgs/MoveItErrorCodes.h>

namespace moveit {
namespace core {

class MoveItErrorCode : public moveit_msgs::MoveItErrorCodes {
 public:
  MoveItErrorCode(int code = 0) { val = code; }
  MoveItErrorCode(const moveit_msgs::MoveItErrorCodes& code) { val = code.val; }
  explicit operator bool() const { return val == SUCCESS; }
  bool operator==(int code) const { return val == code; }
  bool operator!=(int code) const { return val != code; }
};

}  // namespace core
}  // namespace moveit
