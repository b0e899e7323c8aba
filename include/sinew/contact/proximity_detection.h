#pragma once

#include <memory>
#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/contact/feature_pair.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/obstacle_shape.h"
#include "sinew/contact/smooth_pairs.h"
#include "sinew/contact/surface_pairs.h"

namespace sinew {

/// Contacts by local minima of the distance (after Johnson and Willemsen, Six degree-of-freedom haptic rendering of
/// complex polygonal models, 2003).
///
/// A pair of points p on the robot, q on the other side, with contact normal d (unit, from q to p), is a local minimum
/// if it is the nearest pair of every two triangles that hold p and q. That is so exactly if the robot's surface leaves
/// p with slopes d . x >= 0 in all directions x, and the other surface leaves q with slopes -d . x >= 0: the normal
/// cones of both features hold d. All such pairs nearer than the alarm distance are kept, ties included; of pairs that
/// coincide, one.
///
/// A cycle later the minimum may be elsewhere. Pairs are therefore kept as well that miss being one by slopes down to
/// -`slope` in some direction: those that a motion whose gradient stays below `slope` (rotation in rad, strain) could
/// turn into a minimum. From any feature that is not kept, a chain of neighbours, each nearer by more than `slope`
/// times the step, leads down to one that is; such a motion cannot turn the chain around, so that where the kept pairs
/// stay apart, all do. Left over is what is of second order in one step: of a face that turns by an angle w over an
/// obstacle of radius R and slides by s, at most R w^2 / 2 + s w.
///
/// Features, with the distance and normal of each pair:
/// - vertex and face, where the vertex lies above or behind the face: signed height, normal of the face;
/// - two edges that cross, at least one of them bent outwards by more than 0.02 rad: signed along their common normal;
/// - vertex and edge, vertex and vertex, where one of the two points is the local minimum for the other: distance;
/// - vertex, edge, face against plane, sphere, cylinder: minimum of the exact signed distance over the feature; a rim
/// of
///   a cylinder also by 32 points of it against faces. Inside the shape the distance has kinks; a minimum on one takes
///   one of its normals. Boxes and meshes are triangle surfaces, pushed apart from depths up to `max_depth`.
/// In all of them the outward normals of both features must face each other: n_p . d < 0 < n_q . d. A vertex behind
/// several faces counts for the nearest only.
///
/// Self-contact leaves out features whose vertices are the same or neighbours, and pairs nearer than the contact
/// distance at rest; their normals must point against each other, so that no pair looks through the material.
///
/// `update` and the `add...` calls allocate nothing, and the same input gives the same rows.
class ProximityDetection {
 public:
  /// `rest`: node positions [m] at rest. Throws ConfigError.
  ProximityDetection(const ProximitySettings& settings, const CollisionSurface& topology, const std::vector<Vec3>& rest,
                     const std::vector<ObstacleShape>& obstacles, int max_rows);

  /// Moves the surface to `nodes` [m].
  void update(const std::vector<Vec3>& nodes) { surface_.update(nodes); }
  const MovingSurface& surface() const { return surface_; }
  const ProximitySettings& settings() const { return settings_; }

  /// Rows of the surface against obstacle `index` at `pose`, in the frame of the nodes.
  void addObstacle(int index, const Pose& pose, ContactList& list);
  /// Rows of the surface against itself. `regions` are to be those of this surface.
  void addSelf(const RegionPairs& regions, ContactList& list);
  /// Rows of the surface against another soft one (entries of surface 1). False, and no rows, without the room of
  /// `reserveOther`.
  bool addOther(const MovingSurface& other, ContactList& list);
  /// Set-up: makes room for other soft surfaces of at most so many vertices.
  void reserveOther(int max_other_vertices);

 private:
  struct Obstacle {
    ObstacleShape shape;
    std::unique_ptr<MovingSurface> surface;  // of boxes and meshes, as is
    std::unique_ptr<NearPairs> near;
  };
  static int countMostVertices(const std::vector<ObstacleShape>& obstacles);

  ProximitySettings settings_;
  int max_rows_;
  MovingSurface surface_;
  std::vector<Obstacle> obstacles_;
  int most_vertices_;
  SmoothPairs smooth_pairs_;
  SurfacePairs surface_pairs_;
  NearPairs own_near_;
};

}  // namespace sinew
