#pragma once

#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/contact/feature_pair.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/obstacle_shape.h"

namespace sinew {

/// Contacts of a soft surface with a plane, a sphere or a cylinder, whose signed distance phi is known and convex:
/// - a vertex;
/// - an edge where phi has its minimum along the edge strictly between the ends;
/// - a face where phi has its minimum strictly inside;
/// - a point of a cylinder's rim under a face.
class SmoothPairs {
 public:
  SmoothPairs(const ProximitySettings& settings, const CollisionSurface& topology);

  /// `shape.isSmooth()` must hold.
  void addPairs(const MovingSurface& surface, const ObstacleShape& shape, const Pose& pose, int obstacle,
                ContactList& list);

 private:
  struct VertexState {
    int seen = 0;
    Vec3 position, normal;  // in the frame of the shape
    double distance;
  };
  struct EdgeState {
    int seen = 0;
    double t, distance;  // of the minimum along the edge
    bool is_inside;      // strictly between the ends
    Vec3 normal;         // there, in the frame of the shape
  };

  void visit(int triangle);
  void seeVertex(int vertex);
  void seeEdge(int edge);
  void seeFace(int triangle);
  void seeRim();
  void seeRimPoint(int index, const Vec3& radial, double z);
  bool isOutOfReach(int triangle) const;
  bool opensInward(int triangle) const;
  void addRow(PairKind kind, int a, int b, const SurfacePoint& point, const SurfaceDistance& local, double slope,
              double area);

  ProximitySettings settings_;
  PairFilter filter_;
  std::vector<VertexState> vertices_;
  std::vector<EdgeState> edges_;
  int serial_ = 0;

  const MovingSurface* surface_ = nullptr;
  const ObstacleShape* shape_ = nullptr;
  ContactList* list_ = nullptr;
  Mat3 rotation_;  // of the shape
  Vec3 origin_;
  int obstacle_ = 0;
};

}  // namespace sinew
