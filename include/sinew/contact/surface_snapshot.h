#pragma once

#include <vector>

#include "sinew/contact/moving_surface.h"

namespace sinew {

/// Where a surface was, and which way its vertices, edges and faces looked.
class SurfaceSnapshot {
 public:
  enum class Feature { kVertex, kEdge, kFace };

  /// Of a surface with the topology and tree of `surface`, that is nowhere yet. It is cut into parts of triangles that
  /// are near each other at rest.
  explicit SurfaceSnapshot(const MovingSurface& surface);

  void take(const MovingSurface& surface);
  /// Whether since then no normal has turned farther than `turn` [rad, less than a right angle].
  bool keepsDirections(const MovingSurface& surface, double turn) const;
  /// Follows how far each part has moved since then.
  void updateMotion(const MovingSurface& surface);

  int parts() const { return static_cast<int>(parts_.size()); }
  const Box& place(int part) const { return parts_[part].place; }    ///< around its triangles [m]
  const Box& motion(int part) const { return parts_[part].motion; }  ///< around the ways of its corners [m]
  const Vec3& position(int vertex) const { return positions_[vertex]; }
  const PackedBox& box(Feature kind, int index) const { return boxes_[first(kind) + index]; }
  /// Unit, or 0 where there is none.
  const Vec3& direction(Feature kind, int index) const { return directions_[first(kind) + index]; }

 private:
  struct Part {
    std::vector<int> vertices;
    Box place, motion;
  };
  int first(Feature kind) const { return first_[static_cast<int>(kind)]; }

  int first_[3];  // of the vertices, edges and faces among the features
  std::vector<Part> parts_;
  std::vector<Vec3> positions_;
  std::vector<PackedBox> boxes_;
  std::vector<Vec3> directions_;
};

}  // namespace sinew
