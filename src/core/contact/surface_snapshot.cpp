#include "sinew/contact/surface_snapshot.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace sinew {
namespace {

constexpr std::size_t kParts = 16;

// False for what is not a number.
bool isWithinTurn(const Vec3& normal, const Vec3& direction, double squared_cosine) {
  const double along = normal.dot(direction);
  return along > 0 && along * along >= squared_cosine * normal.squaredNorm();
}

}  // namespace

SurfaceSnapshot::SurfaceSnapshot(const MovingSurface& surface)
    : first_{0, surface.topology().vertices(),
             surface.topology().vertices() + static_cast<int>(surface.topology().edges().size())},
      positions_(surface.topology().vertices(), Vec3::Zero()),
      boxes_(first_[2] + surface.topology().triangles().size()),
      directions_(boxes_.size(), Vec3::Zero()) {
  const std::vector<int> order = surface.tree().makeOrder();
  const std::size_t count = std::min(order.size(), kParts);
  for (std::size_t i = 0; i < count; ++i) {
    std::set<int> vertices;
    for (std::size_t k = i * order.size() / count; k < (i + 1) * order.size() / count; ++k) {
      const CollisionSurface::Triangle& corners = surface.topology().triangles()[order[k]];
      vertices.insert(corners.begin(), corners.end());
    }
    parts_.push_back({std::vector<int>(vertices.begin(), vertices.end()), {}, {}});
  }
}

void SurfaceSnapshot::take(const MovingSurface& surface) {
  const CollisionSurface& topology = surface.topology();
  std::size_t next = 0;
  for (int v = 0; v < topology.vertices(); ++v, ++next) {
    positions_[v] = surface.position(v);
    boxes_[next] = PackedBox(Box{surface.position(v), surface.position(v)});
    directions_[next] = surface.vertexNormal(v).normalized();
  }
  for (int e = 0; e < static_cast<int>(topology.edges().size()); ++e, ++next) {
    const auto& ends = topology.edges()[e].vertices;
    boxes_[next] = boxes_[ends[0]];
    boxes_[next].extend(boxes_[ends[1]]);
    directions_[next] = surface.edgeNormal(e).normalized();
  }
  for (int t = 0; t < static_cast<int>(topology.triangles().size()); ++t, ++next) {
    boxes_[next] = boxes_[first(Feature::kEdge) + topology.edgesOf(t)[0]];
    boxes_[next].extend(boxes_[topology.triangles()[t][2]]);
    directions_[next] = surface.faceNormal(t);
  }
  for (Part& part : parts_) {
    part.place = Box();
    for (const int vertex : part.vertices) part.place.extend(positions_[vertex]);
  }
}

bool SurfaceSnapshot::keepsDirections(const MovingSurface& surface, double turn) const {
  const double squared_cosine = std::cos(turn) * std::cos(turn);
  const CollisionSurface& topology = surface.topology();
  const Vec3* direction = directions_.data();
  for (int v = 0; v < topology.vertices(); ++v) {
    if (!isWithinTurn(surface.vertexNormal(v), *direction++, squared_cosine)) return false;
  }
  for (int e = 0; e < static_cast<int>(topology.edges().size()); ++e) {
    if (!isWithinTurn(surface.edgeNormal(e), *direction++, squared_cosine)) return false;
  }
  for (int t = 0; t < static_cast<int>(topology.triangles().size()); ++t) {
    if (!isWithinTurn(surface.faceNormal(t), *direction++, squared_cosine)) return false;
  }
  return true;
}

void SurfaceSnapshot::updateMotion(const MovingSurface& surface) {
  for (Part& part : parts_) {
    part.motion = Box();
    for (const int vertex : part.vertices) part.motion.extend(surface.position(vertex) - positions_[vertex]);
  }
}

}  // namespace sinew
