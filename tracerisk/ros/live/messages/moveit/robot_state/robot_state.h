// MoveIt's RobotState for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <moveit/of_ros/of_ros.h>
#include <moveit/robot_model/robot_model.h>

namespace moveit {
namespace core {

// Where the joints are.
class RobotState {
 public:
  explicit RobotState(const RobotModelConstPtr& model) : model_(model) {}
  const RobotModelConstPtr& getRobotModel() const { return model_; }
  const JointModelGroup* getJointModelGroup(const std::string& name) const
  {
    return model_->getJointModelGroup(name);
  }
  void copyJointGroupPositions(const JointModelGroup* group, std::vector<double>& values) const
  {
    values.clear();
    for (const std::string& name : group->getVariableNames()) values.push_back(positions_.at(name));
  }
  void copyJointGroupPositions(const std::string& group, std::vector<double>& values) const
  {
    copyJointGroupPositions(getJointModelGroup(group), values);
  }
  void setJointGroupPositions(const JointModelGroup* group, const std::vector<double>& values)
  {
    for (std::size_t i = 0; i < values.size(); ++i) positions_[group->getVariableNames()[i]] = values[i];
  }
  void setJointGroupPositions(const std::string& group, const std::vector<double>& values)
  {
    setJointGroupPositions(getJointModelGroup(group), values);
  }
  double getVariablePosition(const std::string& name) const { return positions_.at(name); }
  void setVariablePosition(const std::string& name, double value) { positions_[name] = value; }
  of_ros::sensor_msg::JointState message() const
  {
    of_ros::sensor_msg::JointState state;
    for (const auto& one : positions_) {
      state.name.push_back(one.first);
      state.position.push_back(one.second);
    }
    return state;
  }

 private:
  RobotModelConstPtr model_;
  std::map<std::string, double> positions_;
};
typedef std::shared_ptr<RobotState> RobotStatePtr;
typedef std::shared_ptr<const RobotState> RobotStateConstPtr;

}  // namespace core
}  // namespace moveit

namespace robot_state = moveit::core;
