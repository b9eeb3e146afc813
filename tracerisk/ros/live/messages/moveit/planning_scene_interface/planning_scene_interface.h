// MoveIt's PlanningSceneInterface for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <string>
#include <vector>

#include <moveit_msgs/ApplyPlanningScene.h>
#include <moveit_msgs/CollisionObject.h>
#include <moveit_msgs/GetPlanningScene.h>
#include <ros/ros.h>

namespace moveit {
namespace planning_interface {

class PlanningSceneInterface {
 public:
  explicit PlanningSceneInterface(const std::string& space = "", bool = true) : node_(space)
  {
    apply_ = node_.serviceClient<moveit_msgs::ApplyPlanningScene>("apply_planning_scene");
    get_ = node_.serviceClient<moveit_msgs::GetPlanningScene>("get_planning_scene");
    scene_ = node_.advertise<moveit_msgs::PlanningScene>("planning_scene", 1);
    apply_.waitForExistence();
  }

  std::vector<std::string> getKnownObjectNames(bool = false)
  {
    moveit_msgs::GetPlanningScene call;
    call.request.components.components = moveit_msgs::PlanningSceneComponents::WORLD_OBJECT_NAMES;
    std::vector<std::string> names;
    if (!get_.call(call)) return names;
    for (const auto& object : call.response.scene.world.collision_objects) names.push_back(object.id);
    return names;
  }
  bool applyCollisionObject(const moveit_msgs::CollisionObject& object)
  {
    return applyCollisionObjects({object});
  }
  bool applyCollisionObjects(const std::vector<moveit_msgs::CollisionObject>& objects)
  {
    return applyPlanningScene(with(objects));
  }
  bool applyAttachedCollisionObject(const moveit_msgs::AttachedCollisionObject& object)
  {
    moveit_msgs::PlanningScene scene = with({});
    scene.robot_state.attached_collision_objects = {object};
    return applyPlanningScene(scene);
  }
  bool applyPlanningScene(const moveit_msgs::PlanningScene& scene)
  {
    moveit_msgs::ApplyPlanningScene call;
    call.request.scene = scene;
    return apply_.call(call) && call.response.success;
  }
  void addCollisionObjects(const std::vector<moveit_msgs::CollisionObject>& objects)
  {
    scene_.publish(with(objects));
  }
  void removeCollisionObjects(const std::vector<std::string>& names)
  {
    std::vector<moveit_msgs::CollisionObject> objects(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      objects[i].id = names[i];
      objects[i].operation = moveit_msgs::CollisionObject::REMOVE;
    }
    addCollisionObjects(objects);
  }

 private:
  static moveit_msgs::PlanningScene with(const std::vector<moveit_msgs::CollisionObject>& objects)
  {
    moveit_msgs::PlanningScene scene;
    scene.world.collision_objects = objects;
    scene.robot_state.is_diff = true;
    scene.is_diff = true;
    return scene;
  }

  ros::NodeHandle node_;
  ros::ServiceClient apply_, get_;
  ros::Publisher scene_;
};

}  // namespace planning_interface
}  // namespace moveit
