#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/obstacle.h"

namespace sinew {

/// What a robot does while it is timed, from time 0 on. Before that, at negative times, it comes to where it starts.
struct RobotScene {
  std::string name;
  std::string file;                                                          ///< the robot's description
  std::function<VecX(double)> target;                                        ///< m of the first effectors
  std::function<void(double, std::vector<ObstacleState>&)> place_obstacles;  ///< from where they rest; empty: they stay
  double duration;                                                           ///< s
  std::map<std::string, double> thesis;                                      ///< ms by stage, of its scene of that kind
  double lead_in = 2;                                                        ///< s before time 0
  double rate = 100;                                                         ///< Hz, of controller and simulated robot
  bool self = false;                                                         ///< every part may touch every other

  int leadInCycles() const { return static_cast<int>(lead_in * rate); }
  int timedCycles() const { return static_cast<int>(duration * rate); }
};

/// The scenes of the shipped robots and those of the benchmark itself; `root` is the project's folder.
std::vector<RobotScene> makeRobotScenes(const std::string& root);

}  // namespace sinew
