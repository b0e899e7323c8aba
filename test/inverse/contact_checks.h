#pragma once

// What holds in every scene with contact, whatever the robot:
//
//   SignoriniBreach    law of contact at the solution of each cycle's linear problem
//   calcObstacleDepth  how deep the real surface is in the obstacles' exact shapes
//   SelfDepth          how deep the real surface is in the body's own material
//   ContactWatch       all of these over a run of the controller
//   follow             a run of the controller along targets over time
//   solveRoundTrip     from an actuation to its effectors and back
//
//     ContactWatch watch(controller);
//     for (...) {
//       controller.step(input, output);
//       watch.add(input, output);
//     }
//     watch.check("gripper", 0.0002);
//
// states signorini.gripper_gap, _force, _product, penetration.gripper and gripper.held_cycles.

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "check_line.h"
#include "sinew/common/sampled_signal.h"
#include "sinew/contact/aabb_tree.h"
#include "sinew/contact/closest_point.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/forward_simulator.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {

/// Worst breach of Signorini's law over the solutions that were added.
struct SignoriniBreach {
  double gap = 0;      ///< m below zero
  double force = 0;    ///< below zero, relative to the largest force of its cycle
  double product = 0;  ///< force times gap, relative to the largest force and the largest gap found in its cycle

  void add(const ContactReport& contacts, const ContactList& found) {
    double largest_force = 0, largest_gap = 0;
    for (int i = 0; i < contacts.count; ++i) {
      largest_force = std::max(largest_force, std::abs(contacts.force[i]));
      largest_gap = std::max(largest_gap, std::abs(found.row(i).gap));
    }
    for (int i = 0; i < contacts.count; ++i) {
      gap = std::max(gap, -contacts.gap[i]);
      if (!(largest_force > 0)) continue;
      force = std::max(force, -contacts.force[i] / largest_force);
      product = std::max(product, std::abs(contacts.force[i] * contacts.gap[i]) / (largest_force * largest_gap));
    }
  }

  /// States the figures signorini.`scene`_gap, _force and _product.
  void check(const std::string& scene) const {
    checkFigure("signorini." + scene + "_gap", gap, "<=", 1e-9, "m");
    checkFigure("signorini." + scene + "_force", force, "<=", 1e-9, "1");
    checkFigure("signorini." + scene + "_product", product, "<=", 1e-12, "1");
  }
};

/// visit(point) for the points [m] of a grid of `divisions` squared small triangles, corners and edges included.
template <typename Visit>
void forEachPointOf(const CollisionSurface::Triangle& triangle, const std::vector<Vec3>& nodes, int divisions,
                    const Visit& visit) {
  for (int i = 0; i <= divisions; ++i) {
    for (int j = 0; i + j <= divisions; ++j) {
      const int k = divisions - i - j;
      visit(Vec3((i * nodes[triangle[0]] + j * nodes[triangle[1]] + k * nodes[triangle[2]]) / divisions));
    }
  }
}

/// visit(triangle) for those of the surface that can move.
template <typename Visit>
void forEachMovingTriangle(const RobotModel& robot, const Visit& visit) {
  const auto moves = [&](int node) { return robot.fem().freeIndex(node) >= 0; };
  for (const auto& triangle : robot.surface().triangles) {
    if (std::any_of(triangle.begin(), triangle.end(), moves)) visit(triangle);
  }
}

/// Depth [m] of the deepest point of the surface in an obstacle that is present; 0 where it stays out of all. A missing
/// tail of `obstacles` is where the robot's description has it.
inline double calcObstacleDepth(const RobotModel& robot, const std::vector<Vec3>& nodes,
                                const std::vector<ObstacleState>& obstacles, int divisions = 4) {
  double depth = 0;
  for (std::size_t i = 0; i < robot.obstacles().size(); ++i) {
    const Obstacle& obstacle = robot.obstacles()[i];
    const ObstacleState state = i < obstacles.size() ? obstacles[i] : ObstacleState{obstacle.pose, true};
    if (!state.present) continue;
    for (const Obstacle::Part& part : obstacle.parts) {
      const Pose to_shape = (state.pose * part.origin).inverse();
      forEachMovingTriangle(robot, [&](const auto& triangle) {
        forEachPointOf(triangle, nodes, divisions, [&](const Vec3& point) {
          depth = std::max(depth, -part.shape.calcDistance(to_shape * point).distance);
        });
      });
    }
  }
  return depth;
}

/// Where the body is inside itself.
class SelfDepth {
 public:
  using Triangle = CollisionSurface::Triangle;

  explicit SelfDepth(const RobotModel& robot) : robot_(robot), near_(robot.mesh().nodes.size()) {
    for (const auto& tet : robot.mesh().tets) {
      for (const int a : tet) near_[a].insert(near_[a].end(), tet.begin(), tet.end());
    }
    for (std::vector<int>& list : near_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  /// Depth [m] of the deepest point of the surface in a tetrahedron that is no neighbour of its triangle, up to the
  /// nearest triangle that looks the other way; 0 where there is none.
  double calc(const std::vector<Vec3>& nodes, int divisions = 3) {
    updateBoxes(nodes);
    double depth = 0;
    forEachMovingTriangle(robot_, [&](const Triangle& triangle) {
      const std::vector<int> tets = findOverlapping(nodes, triangle);
      if (tets.empty()) return;
      forEachPointOf(triangle, nodes, divisions, [&](const Vec3& point) {
        const auto holds = [&](int tet) { return isInside(nodes, tet, point); };
        if (std::none_of(tets.begin(), tets.end(), holds)) return;
        depth = std::max(depth, calcWayOut(nodes, triangle, point));
      });
    });
    return depth;
  }

 private:
  void updateBoxes(const std::vector<Vec3>& nodes) {
    boxes_.assign(robot_.mesh().tets.size(), Box());
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      for (const int node : robot_.mesh().tets[t]) boxes_[t].extend(nodes[node]);
    }
  }

  template <typename Corners>
  bool areNeighbours(const Triangle& triangle, const Corners& corners) const {
    return std::any_of(triangle.begin(), triangle.end(), [&](int a) {
      return std::any_of(corners.begin(), corners.end(),
                         [&](int b) { return std::binary_search(near_[a].begin(), near_[a].end(), b); });
    });
  }

  /// Tetrahedra that are no neighbours of the triangle, but whose boxes overlap its own.
  std::vector<int> findOverlapping(const std::vector<Vec3>& nodes, const Triangle& triangle) const {
    Box box;
    for (const int node : triangle) box.extend(nodes[node]);
    std::vector<int> found;
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      if (boxes_[t].overlaps(box) && !areNeighbours(triangle, robot_.mesh().tets[t])) {
        found.push_back(static_cast<int>(t));
      }
    }
    return found;
  }

  bool isInside(const std::vector<Vec3>& nodes, int t, const Vec3& point) const {
    const auto& tet = robot_.mesh().tets[t];
    Mat3 edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = nodes[tet[i + 1]] - nodes[tet[0]];
    const Vec3 weights = edges.inverse() * (point - nodes[tet[0]]);
    return (weights.array() >= 0).all() && weights.sum() <= 1;
  }

  static Vec3 calcNormal(const std::vector<Vec3>& nodes, const Triangle& triangle) {
    return (nodes[triangle[1]] - nodes[triangle[0]]).cross(nodes[triangle[2]] - nodes[triangle[0]]);
  }

  double calcWayOut(const std::vector<Vec3>& nodes, const Triangle& triangle, const Vec3& point) const {
    const Vec3 normal = calcNormal(nodes, triangle);
    double squared = 1;  // m2, more than any robot
    for (const Triangle& other : robot_.surface().triangles) {
      if (calcNormal(nodes, other).dot(normal) >= 0 || areNeighbours(triangle, other)) continue;
      const Vec3 weights = calcClosestWeights(nodes[other[0]], nodes[other[1]], nodes[other[2]], point);
      const Vec3 there = weights[0] * nodes[other[0]] + weights[1] * nodes[other[1]] + weights[2] * nodes[other[2]];
      squared = std::min(squared, (there - point).squaredNorm());
    }
    return std::sqrt(squared);
  }

  const RobotModel& robot_;
  std::vector<std::vector<int>> near_;  // by node: those of its tetrahedra
  std::vector<Box> boxes_;
};

/// Looks on while a controller runs; see the head of this file.
class ContactWatch {
 public:
  explicit ContactWatch(const InverseController& controller)
      : controller_(controller), robot_(controller.robot()), self_depth_(robot_) {}

  /// After each `step`, with what it read and gave.
  void add(const CycleInput& input, const CycleOutput& output) {
    held_ += output.status == CycleStatus::kHeld;
    const ContactReport& contacts = output.contacts;
    if (output.status != CycleStatus::kHeld) breach_.add(contacts, controller_.contacts());
    unproved_ += contacts.count > 0 && !contacts.proved_global;
    most_contacts_ = std::max(most_contacts_, contacts.count);
    for (int i = 0; i < contacts.count; ++i) {
      const bool own = controller_.contacts().row(i).obstacle == kSelfContact;
      double& largest = own ? self_force_ : obstacle_force_;
      largest = std::max(largest, contacts.force[i]);
    }
    ++cycles_;
    measureDepth(input);
  }

  /// States signorini.`scene`_..., penetration.`scene` and `scene`.held_cycles; the depth [m] is that in obstacles and,
  /// where the robot may touch itself, in itself.
  void check(const std::string& scene, double largest_depth) const {
    breach_.check(scene);
    checkFigure("penetration." + scene, 1e3 * depth_, "<=", 1e3 * largest_depth, "mm");
    checkFigure(scene + ".held_cycles", held_, "<=", 0, "1");
    std::printf("%s: %d cycles, %d without a proof of the global optimum, %d contacts at most\n", scene.c_str(),
                cycles_, unproved_, most_contacts_);
  }

  double obstacleForce() const { return obstacle_force_; }  ///< N, largest of a contact with an obstacle
  double selfForce() const { return self_force_; }          ///< N, largest of a contact of the robot with itself
  double depth() const { return depth_; }                   ///< m
  int mostContacts() const { return most_contacts_; }
  int held() const { return held_; }
  int unproved() const { return unproved_; }  ///< cycles in contact without a proof of the global optimum

 private:
  void measureDepth(const CycleInput& input) {
    depth_ = std::max(depth_, calcObstacleDepth(robot_, controller_.nodes(), input.obstacles));
    if (robot_.description().contacts.self) depth_ = std::max(depth_, self_depth_.calc(controller_.nodes()));
  }

  const InverseController& controller_;
  const RobotModel& robot_;
  SelfDepth self_depth_;
  SignoriniBreach breach_;
  int cycles_ = 0, held_ = 0, unproved_ = 0, most_contacts_ = 0;
  double depth_ = 0, obstacle_force_ = 0, self_force_ = 0;
};

/// Cycles along `targets` (layout of CycleInput) from `begin` to `end` [s], 100 a second. The largest effector error
/// [m]. `input` carries everything else, and holds the last targets afterwards.
inline double follow(InverseController& controller, ContactWatch& watch, const SampledSignal& targets, double begin,
                     double end, CycleInput& input, CycleOutput& output) {
  constexpr double kPeriod = 0.01;  // s
  input.targeted.assign(input.targeted.size(), true);
  input.period = kPeriod;
  double error = 0;
  for (double time = begin; time < end; time += kPeriod) {
    targets.calcValue(time, input.targets);
    controller.step(input, output);
    watch.add(input, output);
    error = std::max(error, output.effector_error);
  }
  return error;
}

/// What comes back of an actuation.
struct RoundTrip {
  double difference;      ///< m, of the worst displacement
  double effector_error;  ///< m
  double contact_force;   ///< N, largest one where the forward model ended
};

/// Pulls the robot to `pulled` [m, per actuator] over `steps` load steps, then has the inverse model chase the
/// effectors that were reached, from rest, for `cycles`.
inline RoundTrip solveRoundTrip(const std::shared_ptr<const RobotModel>& robot, const VecX& pulled, int steps,
                                int cycles) {
  ForwardSimulator forward(robot);
  Actuation actuation = forward.makeActuation();
  for (int k = 1; k <= steps; ++k) {
    actuation.value = pulled * k / steps;
    EXPECT_EQ(forward.step(actuation, 0.01), ForwardStatus::kSolved) << "load step " << k;
  }
  EXPECT_EQ(forward.settle(actuation, 1e-9, 1000), ForwardStatus::kSolved);
  InverseController inverse(robot);
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targeted.assign(input.targeted.size(), true);
  input.targets = forward.effectors();
  for (int k = 0; k < cycles; ++k) EXPECT_NE(inverse.step(input, output), CycleStatus::kHeld) << "cycle " << k;
  const double force = forward.contactForce().size() == 0 ? 0 : forward.contactForce().maxCoeff();
  return {(output.displacement - pulled).cwiseAbs().maxCoeff(), output.effector_error, force};
}

}  // namespace sinew
