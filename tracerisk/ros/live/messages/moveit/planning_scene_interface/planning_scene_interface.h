// MoveIt's PlanningSceneInterface for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <moveit/of_ros/of_ros.h>

namespace moveit {
namespace planning_interface {

class PlanningSceneInterface {
 public:
  typedef std::vector<of_ros::moveit_msg::ObjectColor> Colors;

  explicit PlanningSceneInterface(const std::string& space = "", bool waits = true)
      : node_(space),
        apply_(node_.client<of_ros::moveit_srv::ApplyPlanningScene>("apply_planning_scene", waits)),
        get_(node_.client<of_ros::moveit_srv::GetPlanningScene>("get_planning_scene", waits)),
        scene_(node_.publisher<of_ros::moveit_msg::PlanningScene>("planning_scene"))
  {
  }

  std::vector<std::string> getKnownObjectNames(bool = false)
  {
    std::vector<std::string> names;
    for (const auto& object : world(of_ros::moveit_msg::PlanningSceneComponents::WORLD_OBJECT_NAMES)) {
      names.push_back(object.id);
    }
    return names;
  }
  // Return the objects of those names, or all.
  std::map<std::string, of_ros::moveit_msg::CollisionObject> getObjects(
      const std::vector<std::string>& names = {})
  {
    std::map<std::string, of_ros::moveit_msg::CollisionObject> objects;
    for (const auto& object : world(of_ros::moveit_msg::PlanningSceneComponents::WORLD_OBJECT_GEOMETRY)) {
      if (names.empty() || std::find(names.begin(), names.end(), object.id) != names.end()) {
        objects[object.id] = object;
      }
    }
    return objects;
  }
  std::map<std::string, of_ros::geometry_msg::Pose> getObjectPoses(const std::vector<std::string>& names)
  {
    std::map<std::string, of_ros::geometry_msg::Pose> poses;
    for (const auto& object : getObjects(names)) poses[object.first] = object.second.pose;
    return poses;
  }
  // Return the attached objects of those names, or all.
  std::map<std::string, of_ros::moveit_msg::AttachedCollisionObject> getAttachedObjects(
      const std::vector<std::string>& names = {})
  {
    std::map<std::string, of_ros::moveit_msg::AttachedCollisionObject> objects;
    const auto there = scene(of_ros::moveit_msg::PlanningSceneComponents::ROBOT_STATE_ATTACHED_OBJECTS);
    for (const auto& object : there.robot_state.attached_collision_objects) {
      const std::string& id = object.object.id;
      if (names.empty() || std::find(names.begin(), names.end(), id) != names.end()) {
        objects[id] = object;
      }
    }
    return objects;
  }
  bool applyCollisionObject(const of_ros::moveit_msg::CollisionObject& object)
  {
    return applyCollisionObjects({object});
  }
  template <class Color>  // std_msgs/ColorRGBA, of the object for who shows it
  bool applyCollisionObject(const of_ros::moveit_msg::CollisionObject& object, const Color&)
  {
    return applyCollisionObjects({object});
  }
  bool applyCollisionObjects(const std::vector<of_ros::moveit_msg::CollisionObject>& objects,
                             const Colors& colors = {})
  {
    return applyPlanningScene(with(objects, colors));
  }
  bool applyAttachedCollisionObject(const of_ros::moveit_msg::AttachedCollisionObject& object)
  {
    return applyAttachedCollisionObjects({object});
  }
  bool applyAttachedCollisionObjects(
      const std::vector<of_ros::moveit_msg::AttachedCollisionObject>& objects)
  {
    of_ros::moveit_msg::PlanningScene scene = with({}, {});
    scene.robot_state.attached_collision_objects = objects;
    return applyPlanningScene(scene);
  }
  bool applyPlanningScene(const of_ros::moveit_msg::PlanningScene& scene)
  {
    of_ros::moveit_srv::ApplyPlanningScene::Request request;
    of_ros::moveit_srv::ApplyPlanningScene::Response response;
    request.scene = scene;
    return apply_(request, response) && response.success;
  }
  void addCollisionObjects(const std::vector<of_ros::moveit_msg::CollisionObject>& objects,
                           const Colors& colors = {}) const
  {
    scene_(with(objects, colors));
  }
  void removeCollisionObjects(const std::vector<std::string>& names) const
  {
    std::vector<of_ros::moveit_msg::CollisionObject> objects(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      objects[i].id = names[i];
      objects[i].operation = of_ros::moveit_msg::CollisionObject::REMOVE;
    }
    addCollisionObjects(objects);
  }

 private:
  static of_ros::moveit_msg::PlanningScene with(
      const std::vector<of_ros::moveit_msg::CollisionObject>& objects, const Colors& colors)
  {
    of_ros::moveit_msg::PlanningScene scene;
    scene.world.collision_objects = objects;
    scene.object_colors = colors;
    scene.robot_state.is_diff = true;
    scene.is_diff = true;
    return scene;
  }

  std::vector<of_ros::moveit_msg::CollisionObject> world(unsigned int components)
  {
    return scene(components).world.collision_objects;
  }

  of_ros::moveit_msg::PlanningScene scene(unsigned int components)
  {
    of_ros::moveit_srv::GetPlanningScene::Request request;
    of_ros::moveit_srv::GetPlanningScene::Response response;
    request.components.components = components;
    get_(request, response);
    return response.scene;
  }

  of_ros::Node node_;
  of_ros::Client<of_ros::moveit_srv::ApplyPlanningScene> apply_;
  of_ros::Client<of_ros::moveit_srv::GetPlanningScene> get_;
  std::function<void(const of_ros::moveit_msg::PlanningScene&)> scene_;
};

}  // namespace planning_interface
}  // namespace moveit
