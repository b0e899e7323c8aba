#include "sinew/constraint/cable.h"

#include <algorithm>
#include <numeric>

namespace sinew {
namespace {

constexpr double kShortest = 1e-9;  // m; a segment that short has no direction

}  // namespace

Cable::Cable(const CableDescription& description, const FemModel& model, std::vector<EmbeddedPoint> via_points)
    : description_(description), model_(&model), via_points_(std::move(via_points)) {
  for (std::size_t i = 0; i < via_points_.size(); ++i) {
    segments_.emplace_back(model, i == 0 ? nullptr : &via_points_[i - 1], via_points_[i]);
    const int point = static_cast<int>(i);
    rest_segments_.push_back((pointAt(point + 1, model.rest()) - pointAt(point, model.rest())).norm());
  }
  rest_length_ = std::accumulate(rest_segments_.begin(), rest_segments_.end(), 0.0);
}

Vec3 Cable::pointAt(int i, const std::vector<Vec3>& positions) const {
  return i == 0 ? description_.pull_point : calcPosition(via_points_[i - 1], positions);
}

// Calls use(i, direction, length) for each segment, from point i to point i + 1, that is long enough to have a
// direction.
template <typename Use>
void Cable::forEachSegment(const std::vector<Vec3>& positions, const Use& use) const {
  Vec3 previous = pointAt(0, positions);
  for (int i = 0; i + 1 < points(); ++i) {
    const Vec3 next = pointAt(i + 1, positions);
    const Vec3 span = next - previous;
    const double length = span.norm();
    if (length > kShortest) use(i, Vec3(span / length), length);
    previous = next;
  }
}

double Cable::calcDisplacement(const std::vector<Vec3>& positions) const {
  double sum = 0;
  forEachSegment(positions, [&](int, const Vec3&, double length) { sum += length; });
  return rest_length_ - sum;
}

void Cable::addRow(const std::vector<Vec3>& positions, ConstraintRows& rows) const {
  rows.beginRow();
  forEachSegment(positions, [&](int i, const Vec3& direction, double) {
    if (i > 0) rows.add(via_points_[i - 1], direction);
    rows.add(via_points_[i], -direction);
  });
}

void Cable::addLoadStiffness(const std::vector<Vec3>& positions, double tension, BlockMatrix& matrix) const {
  if (!(tension > 0)) return;
  forEachSegment(positions, [&](int i, const Vec3& direction, double length) {
    segments_[i].addTo(matrix, tension / length * (Mat3::Identity() - direction * direction.transpose()));
  });
}

void Cable::addTube(const std::vector<Vec3>& positions, VecX* force, BlockMatrix* matrix) const {
  if (!(description_.tube_stiffness > 0)) return;
  const auto addForce = [&](const EmbeddedPoint& point, const Vec3& value) {
    for (int k = 0; k < 4; ++k) {
      const int node = model_->freeIndex(point.nodes[k]);
      if (node >= 0) force->segment<3>(3 * node) += point.weights[k] * value;
    }
  };
  forEachSegment(positions, [&](int i, const Vec3& direction, double length) {
    if (i == 0 || rest_segments_[i] <= kShortest) return;  // the tube starts where the cable enters the body
    const double stiffness = description_.tube_stiffness / rest_segments_[i];
    const double pull = stiffness * (length - rest_segments_[i]);
    if (force != nullptr) {
      addForce(via_points_[i - 1], pull * direction);
      addForce(via_points_[i], -pull * direction);
    }
    if (matrix != nullptr) {
      const Mat3 along = direction * direction.transpose();
      segments_[i].addTo(*matrix, stiffness * along + std::max(0.0, pull / length) * (Mat3::Identity() - along));
    }
  });
}

void Cable::calcPoints(const std::vector<Vec3>& positions, std::vector<Vec3>& points_out) const {
  points_out.resize(static_cast<std::size_t>(points()));
  for (int i = 0; i < points(); ++i) points_out[i] = pointAt(i, positions);
}

}  // namespace sinew
