// MoveIt's RobotModel for machines without MoveIt: see move_group_interface.h.
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <moveit/of_ros/of_ros.h>

namespace moveit {
namespace core {

// A planning group: its name, the joints that it moves, and the links behind all of its joints.
class JointModelGroup {
 public:
  JointModelGroup(std::string name = {}, std::vector<std::string> joints = {},
                  std::vector<std::string> links = {})
      : name_(std::move(name)), joints_(std::move(joints)), links_(std::move(links)) {}
  const std::string& getName() const { return name_; }
  const std::vector<std::string>& getVariableNames() const { return joints_; }
  const std::vector<std::string>& getActiveJointModelNames() const { return joints_; }
  const std::vector<std::string>& getLinkModelNames() const { return links_; }
  std::size_t getVariableCount() const { return joints_.size(); }

 private:
  std::string name_;
  std::vector<std::string> joints_, links_;
};

// The groups, named states and end effectors of the robot, as its parameters describe them.
class RobotModel {
 public:
  // Return the robot, which is read when it is first asked for.
  static std::shared_ptr<const RobotModel> get(const of_ros::Node& node)
  {
    static const std::shared_ptr<const RobotModel> model(new RobotModel(node));
    return model;
  }
  const JointModelGroup* getJointModelGroup(const std::string& name) const
  {
    const auto found = groups_.find(name);
    return found == groups_.end() ? nullptr : &found->second;
  }
  std::vector<std::string> getJointModelGroupNames() const
  {
    std::vector<std::string> names;
    for (const auto& group : groups_) names.push_back(group.first);
    return names;
  }
  std::map<std::string, std::map<std::string, double>> states(const std::string& group) const
  {
    const auto found = states_.find(group);
    return found == states_.end() ? decltype(states(group)){} : found->second;
  }
  std::string tip(const std::string& group) const
  {
    const auto found = tips_.find(group);
    return found == tips_.end() ? "" : found->second;
  }
  // Whether a joint can be at a position, to within a tolerance.
  bool isWithin(const std::string& joint, double position, double tolerance) const
  {
    for (const auto& one : joints_) {
      if (one.second.name != joint) continue;
      return position >= one.second.lower - tolerance && position <= one.second.upper + tolerance;
    }
    return false;
  }
  // Where a joint is unless something says otherwise: at zero, or midway where that is out of limits.
  double usual(const std::string& joint) const
  {
    if (isWithin(joint, 0.0, 0.0)) return 0.0;
    for (const auto& one : joints_) {
      if (one.second.name == joint) return (one.second.lower + one.second.upper) / 2.0;
    }
    return 0.0;
  }
  const std::string& getModelFrame() const { return root_; }
  const std::string& getName() const { return name_; }

 private:
  typedef std::map<std::string, std::string> Tag;
  struct Joint {
    std::string name, parent, child;
    bool moves = false;
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
  };

  explicit RobotModel(const of_ros::Node& node)
  {
    const std::string urdf = node.description("robot_description");
    const std::string srdf = node.description("robot_description_semantic");
    if (urdf.empty() || srdf.empty()) {
      node.fatal("robot_description or robot_description_semantic is not set");
      throw std::runtime_error("Unable to construct robot model");
    }
    Joint joint;
    std::set<std::string> children;
    for (const Tag& tag : tags(urdf)) {
      const std::string& is = tag.at("<");
      if (is == "robot" && tag.count("name")) name_ = tag.at("name");
      if (is == "joint" && tag.count("type")) {
        joint.name = tag.at("name");
        joint.moves = moves(tag.at("type"));
      }
      if (is == "parent" && tag.count("link")) joint.parent = tag.at("link");
      if (is == "child" && tag.count("link")) joint.child = tag.at("link");
      if (is == "mimic") joint.moves = false;
      if (is == "limit" && tag.count("lower")) joint.lower = std::stod(tag.at("lower"));
      if (is == "limit" && tag.count("upper")) joint.upper = std::stod(tag.at("upper"));
      if (is == "/joint" && !joint.child.empty()) joints_[joint.child] = joint, joint = Joint();
    }
    for (const auto& one : joints_) children.insert(one.first);
    for (const auto& one : joints_) {
      if (!children.count(one.second.parent)) root_ = one.second.parent;
    }
    readGroups(tags(srdf));
  }

  void readGroups(const std::vector<Tag>& srdf)
  {
    std::string group, state, of;
    std::map<std::string, std::vector<std::string>> links;
    std::map<std::string, std::string> ends;
    for (const Tag& tag : srdf) {
      const std::string& is = tag.at("<");
      if (is == "group" && group.empty()) {
        group = tag.count("/") ? "" : tag.at("name");
        links[tag.at("name")];
      } else if (is == "group" && !group.empty()) {
        for (const std::string& link : links[tag.at("name")]) add(links[group], link);
      } else if (is == "/group") {
        group.clear();
      } else if (is == "chain") {
        for (const std::string& link : chain(tag.at("base_link"), tag.at("tip_link"))) {
          add(links[group], link);
        }
        tips_[group] = tag.at("tip_link");
      } else if (is == "link" && !group.empty() && joints_.count(tag.at("name"))) {
        add(links[group], tag.at("name"));
      } else if (is == "end_effector" && tag.count("parent_group")) {
        ends[tag.at("parent_group")] = tag.at("parent_link");
      } else if (is == "group_state") {
        state = tag.at("name"), of = tag.at("group");
        states_[of][state];
      } else if (is == "/group_state") {
        state.clear();
      } else if (is == "joint" && !state.empty()) {
        states_[of][state][tag.at("name")] = std::stod(tag.at("value"));
      } else if (is == "joint" && !group.empty()) {
        for (const auto& one : joints_) {
          if (one.second.name != tag.at("name")) continue;
          add(links[group], one.first);
          if (!tips_.count(group) || tips_[group] == one.second.parent) tips_[group] = one.first;
        }
      }
    }
    for (const auto& end : ends) tips_[end.first] = end.second;  // before the end of a chain
    for (const auto& one : links) {
      std::vector<std::string> joints;
      for (const std::string& link : one.second) {
        if (joints_[link].moves) joints.push_back(joints_[link].name);
      }
      groups_[one.first] = JointModelGroup(one.first, joints, one.second);
    }
  }

  std::vector<std::string> chain(const std::string& base, const std::string& tip) const
  {
    std::vector<std::string> links;
    for (std::string link = tip; link != base && joints_.count(link); link = joints_.at(link).parent) {
      links.insert(links.begin(), link);
    }
    return links;
  }

  static bool moves(const std::string& type) { return type != "fixed" && type != "floating"; }

  static void add(std::vector<std::string>& names, const std::string& name)
  {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }

  // The tags of an XML text in turn: the name under "<", attributes, and "/" for one without an end.
  static std::vector<Tag> tags(const std::string& text)
  {
    std::vector<Tag> tags;
    for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
      if (text.compare(at, 4, "<!--") == 0) {
        at = text.find("-->", at);
        continue;
      }
      const std::size_t end = text.find('>', at);
      if (end == std::string::npos) break;
      std::size_t place = text.find_first_of(" \t\r\n/>", at + 2);
      Tag tag = {{"<", text.substr(at + 1, place - at - 1)}};
      if (text[end - 1] == '/') tag["/"] = "";
      while ((place = text.find('=', place)) < end) {
        std::size_t begin = text.find_last_not_of(" \t\r\n", place - 1);
        const std::size_t last = begin;
        begin = text.find_last_of(" \t\r\n", begin) + 1;
        const std::size_t open = text.find_first_of("\"'", place);
        const std::size_t close = text.find(text[open], open + 1);
        tag[text.substr(begin, last - begin + 1)] = text.substr(open + 1, close - open - 1);
        place = close;
      }
      tags.push_back(tag);
      at = end;
    }
    return tags;
  }

  std::string name_, root_;
  std::map<std::string, Joint> joints_;  // by the link that each carries
  std::map<std::string, JointModelGroup> groups_;
  std::map<std::string, std::map<std::string, std::map<std::string, double>>> states_;
  std::map<std::string, std::string> tips_;
};
typedef std::shared_ptr<const RobotModel> RobotModelConstPtr;

}  // namespace core
}  // namespace moveit
