#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/contact/depth_view.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/obstacle_shape.h"

namespace sinew {

struct VolumeSettings {
  double contact_distance = 1e-3;  ///< m, distance at which the gap is 0, of parallel faces
  double dilation = 2.5e-3;        ///< m by which obstacles grow: the distance at which a volume begins
  double sharpness = 4;            ///< power of the depth with which parts of a region count in its row; 0: all alike
  int pixels = 64;                 ///< along each side of a view
  double appear = 0.1;             ///< mean thickness, as a part of the dilation, at which a region becomes a row
  double vanish = 0.02;            ///< and below which it is given up

  /// Throws ConfigError. A pointed contact is deepest at its tip, by (p + 3) / (p + 1) of its mean with sharpness p: a
  /// dilation beyond the bound would let it touch where its row is satisfied.
  void check() const;
};

/// One connected part of the intersection of the surface with a dilated obstacle.
struct VolumeRegion {
  int id = 0;                    ///< stays with the region from cycle to cycle
  double volume = 0;             ///< m3
  Vec3 boundary = Vec3::Zero();  ///< m2, the soft surface inside the obstacle: integral of its outward normal
  double area = 0;               ///< m2, the overlap
  Vec3 centre = Vec3::Zero();    ///< m
  Vec3 extent = Vec3::Zero();    ///< m, half sizes
};

/// Contacts by intersection volume, from layered depths (after Allard, Faure, Courtecuisse, Falipou, Duriez and Kry,
/// Volume contact constraints at arbitrary resolution, ACM Trans. Graph. 29(4), 2010).
///
/// Obstacles are grown by `dilation` a, and the intersection with the soft surface is seen along x, y and z through
/// `pixels` squared rays over the overlap of both bounding boxes. Stretches that overlap in neighbouring pixels, or
/// that cross in two views, are one region, as are parts less than a pixel apart; each region is one row
///   gap = (V_ref - V) / S,   V_ref = S (a - contact distance),
/// S the overlap area |integral of the soft surface's normal over its part inside|, in m: for parallel faces the
/// distance less the contact distance. A plain intersection volume would vanish, with its gradient, where the row is
/// satisfied. In V and S of each view a ray counts by (its way inside / the longest)^p, so that V / S is nearly the
/// greatest depth, and still smooth: the plain mean lets round bodies sink into each other. The normal is that of the
/// plain overlap.
///   d gap / d x_v = -dV / d x_v / S,   V_ref, S and these weights held,
/// dV / d x_v along each axis from the view along it: the sum over the pixels of a region's ends on the soft surface,
/// of pixel area times the weight of v there, positive where the ray leaves. V is the mean of the three views weighted
/// by the square of the contact normal's entries.
class VolumeDetection {
 public:
  VolumeDetection(const VolumeSettings& settings, const CollisionSurface& topology,
                  const std::vector<ObstacleShape>& obstacles, int max_regions);

  /// Adds one row a region of `surface`, which has the topology given at construction, in obstacle `index` at `pose`.
  /// False if a view or the regions found no room: then some rows are missing or too small.
  bool addObstacle(const MovingSurface& surface, int index, const Pose& pose, ContactList& list);

  /// All regions of the last `addObstacle`, also those that are no row.
  const std::vector<VolumeRegion>& regions() const { return regions_; }

 private:
  struct Obstacle {
    ObstacleShape shape;
    std::unique_ptr<MovingSurface> surface;  // of a mesh, dilated
    std::vector<VolumeRegion> previous;
  };
  struct Sum {
    std::array<double, 3> volume{}, covered{}, longest{};
    Vec3 moment = Vec3::Zero();
    double weight = 0;
    Vec3 boundary = Vec3::Zero();
    Box box;
  };

  bool updateViews(const MovingSurface& surface, Obstacle& obstacle, const Pose& pose);
  Box calcObstacleBox(const Obstacle& obstacle, const Pose& pose) const;
  void joinSegments();
  void joinPixels(const DepthView& view, int first, int pixel, int other);
  void joinViews(int k);
  int find(int segment);
  void join(int a, int b);
  bool collectRegions();
  double calcWeight(int k, const DepthView::Segment& segment, int region) const;
  static void addToSum(const DepthView& view, const DepthView::Segment& segment, double weight, Sum& sum);
  void weighRegions();
  double calcDepth(int region) const;
  Vec3 calcShares(int region) const;
  VolumeRegion makeRegion(const Sum& sum) const;
  void nameRegions(Obstacle& obstacle);
  void addRow(const MovingSurface& surface, int obstacle, int region, ContactList& list);
  void collectGradient(const MovingSurface& surface, int region);
  void addGradient(const MovingSurface& surface, const DepthView& view, int layer, double factor);

  VolumeSettings settings_;
  int max_regions_;
  std::vector<Obstacle> obstacles_;
  std::vector<DepthView> views_;
  std::array<int, 4> first_{};  // number of the first segment of each view
  std::vector<int> parent_;     // by segment of all views: union-find
  std::vector<int> region_of_;  // by segment
  std::vector<Sum> sums_, weighted_sums_;
  std::vector<VolumeRegion> regions_;
  std::vector<char> is_taken_;
  std::vector<Vec3> gradient_;  // dV/dx by vertex
  std::vector<char> is_touched_;
  std::vector<int> touched_;
  std::vector<ContactEntry> entries_;
};

}  // namespace sinew
