// Stands for MoveIt's header of trajectories on machines without MoveIt: see move_group_interface.h.
#pragma once

#include <moveit/robot_state/robot_state.h>
