// What a goal of move_group asks for: see move_group_interface.h.
#pragma once

#include <map>
#include <string>

#include <moveit/of_ros/of_ros.h>

namespace moveit {
namespace planning_interface {

inline of_ros::moveit_msg::Constraints jointConstraints(const std::map<std::string, double>& joints,
                                                        double tolerance)
{
  of_ros::moveit_msg::Constraints constraints;
  for (const auto& joint : joints) {
    of_ros::moveit_msg::JointConstraint constraint;
    constraint.joint_name = joint.first;
    constraint.position = joint.second;
    constraint.tolerance_above = constraint.tolerance_below = tolerance;
    constraint.weight = 1.0;
    constraints.joint_constraints.push_back(constraint);
  }
  return constraints;
}

inline of_ros::moveit_msg::PositionConstraint positionConstraint(const std::string& frame,
                                                                 const of_ros::geometry_msg::Point& point,
                                                                 const std::string& link, double tolerance)
{
  of_ros::moveit_msg::PositionConstraint constraint;
  constraint.header.frame_id = frame;
  constraint.link_name = link;
  of_ros::shape_msg::SolidPrimitive sphere;
  sphere.type = of_ros::shape_msg::SolidPrimitive::SPHERE;
  sphere.dimensions.resize(1);
  sphere.dimensions[0] = tolerance;
  of_ros::geometry_msg::Pose centre;
  centre.position = point;
  centre.orientation.w = 1.0;
  constraint.constraint_region.primitives = {sphere};
  constraint.constraint_region.primitive_poses = {centre};
  constraint.weight = 1.0;
  return constraint;
}

inline of_ros::moveit_msg::OrientationConstraint orientationConstraint(
    const std::string& frame, const of_ros::geometry_msg::Quaternion& turn, const std::string& link,
    double tolerance)
{
  of_ros::moveit_msg::OrientationConstraint constraint;
  constraint.header.frame_id = frame;
  constraint.link_name = link;
  constraint.orientation = turn;
  constraint.absolute_x_axis_tolerance = tolerance;
  constraint.absolute_y_axis_tolerance = tolerance;
  constraint.absolute_z_axis_tolerance = tolerance;
  constraint.weight = 1.0;
  return constraint;
}

}  // namespace planning_interface
}  // namespace moveit
