#pragma once

#include <string>
#include <vector>

#include "sinew/constraint/constraint_rows.h"
#include "sinew/constraint/segment_stiffness.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

/// A cable from a pull point fixed in the robot's frame through via points carried by the body, free of friction, its
/// last via point its anchor. Displacement delta = L0 - L, length pulled in [m]; effort is the tension [N], and
/// H^T tension, H = -dL/dx, the nodal force.
class Cable {
 public:
  Cable(const CableDescription& description, const FemModel& model, std::vector<EmbeddedPoint> via_points);

  const CableDescription& description() const { return description_; }
  double restLength() const { return rest_length_; }
  int points() const { return static_cast<int>(via_points_.size()) + 1; }
  int maxEntries() const { return 8 * points(); }

  double calcDisplacement(const std::vector<Vec3>& positions) const;
  void addRow(const std::vector<Vec3>& positions, ConstraintRows& rows) const;
  /// Tension T turns with its segments: T d2L/dx2 = T (I - u u^T) / length on each, positive semi-definite for T >= 0.
  void addLoadStiffness(const std::vector<Vec3>& positions, double tension, BlockMatrix& matrix) const;
  /// The stiff tube along the via points: forces into `force`, tangent into `matrix` (each may be null).
  void addTube(const std::vector<Vec3>& positions, VecX* force, BlockMatrix* matrix) const;
  /// Pull point first [m].
  void calcPoints(const std::vector<Vec3>& positions, std::vector<Vec3>& points) const;

 private:
  template <typename Use>
  void forEachSegment(const std::vector<Vec3>& positions, const Use& use) const;
  Vec3 pointAt(int i, const std::vector<Vec3>& positions) const;

  CableDescription description_;
  const FemModel* model_;
  std::vector<EmbeddedPoint> via_points_;
  std::vector<SegmentStiffness> segments_;  // segment i runs from point i to point i + 1
  std::vector<double> rest_segments_;       // m
  double rest_length_ = 0;
};

}  // namespace sinew
