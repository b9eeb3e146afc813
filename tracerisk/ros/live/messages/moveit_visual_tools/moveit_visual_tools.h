// What shows plans in RViz: nothing is shown, and nobody is asked. What would change the planning
// scene is left out.
#pragma once

#include <moveit/robot_state/robot_state.h>

#include <iostream>
#include <memory>
#include <string>

#if __has_include(<Eigen/Geometry>)
#include <Eigen/Geometry>
#elif __has_include(<eigen3/Eigen/Geometry>)
#include <eigen3/Eigen/Geometry>
#endif

namespace rviz_visual_tools {

enum Colors {
  BLACK, BROWN, BLUE, CYAN, GREY, DARK_GREY, GREEN, LIME_GREEN, MAGENTA, ORANGE, PURPLE, RED, PINK,
  WHITE, YELLOW, TRANSLUCENT, TRANSLUCENT_LIGHT, TRANSLUCENT_DARK, RAND, CLEAR, DEFAULT
};
enum Scales {
  XXXXSMALL, XXXSMALL, XXSMALL, XSMALL, SMALL, MEDIUM, LARGE, XLARGE, XXLARGE, XXXLARGE, XXXXLARGE
};
using colors = Colors;
using scales = Scales;

}  // namespace rviz_visual_tools

#define TRACERISK_NOT_SHOWN(name)                                    \
  template <class... Any>                                            \
  bool name(const Any&...) const                                     \
  {                                                                  \
    return true;                                                     \
  }

namespace moveit_visual_tools {

class MoveItVisualTools {
 public:
  template <class... Any>
  explicit MoveItVisualTools(const Any&...)
  {
  }

  // The next step comes at once: nobody presses the button for it.
  void prompt(const std::string& text) const { std::cout << text << std::endl; }

  TRACERISK_NOT_SHOWN(deleteAllMarkers)
  TRACERISK_NOT_SHOWN(enableBatchPublishing)
  TRACERISK_NOT_SHOWN(hideRobot)
  TRACERISK_NOT_SHOWN(loadMarkerPub)
  TRACERISK_NOT_SHOWN(loadRemoteControl)
  TRACERISK_NOT_SHOWN(loadRobotStatePub)
  TRACERISK_NOT_SHOWN(loadTrajectoryPub)
  TRACERISK_NOT_SHOWN(publishArrow)
  TRACERISK_NOT_SHOWN(publishAxis)
  TRACERISK_NOT_SHOWN(publishAxisLabeled)
  TRACERISK_NOT_SHOWN(publishCuboid)
  TRACERISK_NOT_SHOWN(publishLine)
  TRACERISK_NOT_SHOWN(publishPath)
  TRACERISK_NOT_SHOWN(publishRobotState)
  TRACERISK_NOT_SHOWN(publishSphere)
  TRACERISK_NOT_SHOWN(publishSpheres)
  TRACERISK_NOT_SHOWN(publishText)
  TRACERISK_NOT_SHOWN(publishTrajectoryLine)
  TRACERISK_NOT_SHOWN(publishTrajectoryPath)
  TRACERISK_NOT_SHOWN(setAlpha)
  TRACERISK_NOT_SHOWN(trigger)
};

using MoveItVisualToolsPtr = std::shared_ptr<MoveItVisualTools>;

}  // namespace moveit_visual_tools

#undef TRACERISK_NOT_SHOWN
