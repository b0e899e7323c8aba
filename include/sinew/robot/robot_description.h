#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "sinew/common/cholesky_method.h"
#include "sinew/common/types.h"
#include "sinew/robot/obstacle_description.h"
#include "sinew/robot/region_description.h"

namespace sinew {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Closed interval with a bound on the change per second, in the unit of what it limits.
struct Limits {
  double min = -kUnlimited;
  double max = kUnlimited;
  double rate = kUnlimited;  ///< per second
};

struct MaterialDescription {
  int region = -1;           ///< mesh region tag, -1 for every region not named elsewhere
  double young_modulus = 0;  ///< Pa
  double poisson_ratio = 0;  ///< 1
  double density = 0;        ///< kg/m3; 0 when total_mass is given
  double total_mass = 0;     ///< kg of the whole region; 0 when density is given
};

/// Nodes of the mesh that do not move: those in the region, and those listed.
struct FixedNodesDescription : RegionDescription {
  std::vector<int> nodes;
};

/// A cable runs from its pull point, fixed in the robot's frame, through the via points, carried by the body.
struct CableDescription {
  std::string name;
  Vec3 pull_point = Vec3::Zero();  ///< m
  std::vector<Vec3> via_points;    ///< m, at rest, from the pull point outwards
  Limits displacement;             ///< m, cable pulled in is positive
  Limits tension;                  ///< N; min 0 unless said otherwise: a cable pulls only
  double tube_stiffness = 0;       ///< N (E A) of a stiff tube along the via points, 0 for none
};

struct EffectorDescription {
  std::string name;
  Vec3 point = Vec3::Zero();                     ///< m, at rest
  std::array<bool, 3> axes{{true, true, true}};  ///< controlled axes x, y, z of the robot's frame
  double weight = 1;                             ///< 1
  bool hold = false;                             ///< its error is zero before any other is made small
};

/// A driven rail under the whole robot: every position of the description travels along `axis`, gravity and obstacles
/// do not.
struct CarrierDescription {
  std::string name;           ///< empty when there is none
  Vec3 axis = Vec3::UnitX();  ///< direction of positive travel
  Limits displacement;        ///< m
};

/// What bounds an actuator: a cable, or the carrier, whose effort is the force that contacts ask of its drive.
struct ActuatorLimits {
  std::string name;
  Limits displacement;  ///< m
  Limits effort;        ///< N
};

enum class MotionModel { kStatic, kDynamic };

/// Settings of the inverse controller.
struct ControlDescription {
  MotionModel model = MotionModel::kStatic;
  CholeskyMethod cholesky = CholeskyMethod::kSupernodal;
  int threads = 1;                ///< that factorise and condense, the cycle's own among them
  int newton_steps = 1;           ///< at most this many linearisations in a cycle
  double max_node_step = 0.01;    ///< m a node may move in one linearisation
  double reach_per_cycle = 0.02;  ///< m of weighted effector error chased in one cycle
  double smoothing = 0;           ///< 1, weight on the change of effort in a cycle, vanishes at rest
  int max_pieces = 200;           ///< quadratic programmes that a cycle's search among contacts may solve
  int max_nodes = 200;            ///< relaxations likewise, to prove its answer
  double search_time = 0;         ///< s that the search may take; 0 for counts alone, which make it repeatable
  double switching_margin =
      0.02;  ///< 1, by which share of the error the goal may be off without a leap to other contacts
  double switching_reach = kUnlimited;  ///< m by which an actuator may leave its present displacement for them
};

/// Everything that is known of a robot before it moves: read from one YAML file, and one URDF for frames.
struct RobotDescription {
  std::string name;
  std::string file;  ///< of the description itself
  std::string mesh_file;
  double mesh_scale = 1;         ///< m per unit of the mesh file
  int mesh_pieces = 1;           ///< that share no node; each is held by fixed nodes of its own
  std::string urdf_file;         ///< empty when there is none
  std::string frame;             ///< of the mesh, and of every position below
  Vec3 gravity = Vec3::Zero();   ///< m/s2, in `frame`
  double damping_mass = 0;       ///< 1/s, Rayleigh: D = damping_mass M + damping_stiffness K
  double damping_stiffness = 0;  ///< s
  std::vector<MaterialDescription> materials;
  FixedNodesDescription fixed;
  std::vector<CableDescription> cables;
  CarrierDescription carrier;
  std::vector<EffectorDescription> effectors;
  ControlDescription control;
  std::vector<ObstacleDescription> obstacles;
  ContactDescription contacts;
};

/// Every actuator in its order: the cables, then the carrier where there is one.
std::vector<ActuatorLimits> listActuators(const RobotDescription& robot);

/// Reads a robot's YAML and its URDF; the keys that it leaves out come from the YAML that it names as its base. Throws
/// ConfigError with the key's full name, the value and what is right.
RobotDescription readRobotDescription(const std::string& path);

}  // namespace sinew
