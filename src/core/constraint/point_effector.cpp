#include "sinew/constraint/point_effector.h"

#include <algorithm>

namespace sinew {

int PointEffector::rowCount() const {
  return static_cast<int>(std::count(description_.axes.begin(), description_.axes.end(), true));
}

void PointEffector::addRows(ConstraintRows& rows) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (!description_.axes[axis]) continue;
    rows.beginRow();
    rows.add(point_, description_.weight * Vec3::Unit(axis));
  }
}

void PointEffector::calcError(const std::vector<Vec3>& positions, const Vec3& target, double* values) const {
  const Vec3 error = description_.weight * (calcPosition(positions) - target);
  for (int axis = 0; axis < 3; ++axis) {
    if (description_.axes[axis]) *values++ = error[axis];
  }
}

}  // namespace sinew
