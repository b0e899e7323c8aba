#pragma once

#include "sinew/constraint/constraint_rows.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

/// A point of the body that is to follow a target, along some axes of the robot's frame. A row of value
/// delta = weight (position - target) per controlled axis.
class PointEffector {
 public:
  PointEffector(const EffectorDescription& description, const EmbeddedPoint& point)
      : description_(description), point_(point) {}

  const EffectorDescription& description() const { return description_; }
  int rowCount() const;
  Vec3 calcPosition(const std::vector<Vec3>& positions) const { return sinew::calcPosition(point_, positions); }
  void addRows(ConstraintRows& rows) const;
  /// Writes `rowCount()` values from `values[0]` on [m].
  void calcError(const std::vector<Vec3>& positions, const Vec3& target, double* values) const;

 private:
  EffectorDescription description_;
  EmbeddedPoint point_;
};

}  // namespace sinew
