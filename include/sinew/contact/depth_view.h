#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/contact/aabb_tree.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/obstacle_shape.h"

namespace sinew {

/// A solid body seen along one axis through a grid of pixels: for every pixel, the stretches of its ray that lie in a
/// soft surface and in an obstacle at once. All room is taken at construction.
class DepthView {
 public:
  /// Where a ray passes through a triangle of the soft surface.
  struct Layer {
    double depth;  // m
    int triangle;
    Vec3 weights;   // of its corners
    bool is_front;  // the ray enters
    int next;       // of the same pixel, deeper; -1: none
  };
  struct Segment {
    int pixel;
    double begin, end;           // m along the axis
    int begin_layer, end_layer;  // -1: an end on the obstacle
  };

  /// Looks along +axis (0, 1, 2); `pixels` along each side of the grid; room for `max_layers`.
  DepthView(int axis, int pixels, int max_layers);

  /// Pixels fill `box`, of which the other two axes count. False if layers or segments found no room.
  bool update(const MovingSurface& soft, const ObstacleShape& obstacle, double dilation, const Pose& pose,
              const Box& box);
  bool update(const MovingSurface& soft, const MovingSurface& obstacle, const Box& box);

  /// Sees nothing.
  void clear();

  int axis() const { return axis_; }
  double pixelArea() const { return step_u_ * step_v_; }  ///< m2
  const std::vector<Segment>& segments() const { return segments_; }
  const Layer& layer(int index) const { return layers_[index]; }
  /// The segments of a pixel, from its first up to that of the next pixel, in order of depth.
  int firstSegment(int pixel) const { return first_segment_[pixel]; }
  int pixels() const { return pixels_; }

  Vec3 calcMiddle(const Segment& segment) const;
  /// Whether two segments overlap in depth, or nearly so: less than a pixel of the other views is between them.
  bool areJoined(const Segment& a, const Segment& b) const {
    return a.begin < b.end + step_depth_ && b.begin < a.end + step_depth_;
  }
  /// Index of the segment that holds `point`, up to a pixel of the other views; -1 if none.
  int findSegment(const Vec3& point) const;

 private:
  struct Stretch {
    double begin, end;
    int begin_layer, end_layer;
  };

  void start(const Box& box);
  void rasterise(const MovingSurface& surface, std::vector<int>& first_layer);
  void addTriangle(const MovingSurface& surface, int triangle, std::vector<int>& first_layer);
  void addLayer(int pixel, const Layer& layer, std::vector<int>& first_layer);
  void collectStretches(int first_layer, bool is_soft, std::vector<Stretch>& stretches);
  void addChord(int pixel, const ObstacleShape& obstacle, double dilation, const Pose& pose);
  void intersect(int pixel);
  Vec3 calcPoint(int pixel, double depth) const;
  int calcPixel(double value, double lower, double step) const;

  int axis_, u_, v_, pixels_;
  double lower_u_ = 0, lower_v_ = 0, step_u_ = 0, step_v_ = 0, step_depth_ = 0;
  Box box_;
  bool has_room_ = true;
  std::vector<Layer> layers_;
  std::vector<Segment> segments_;
  std::vector<int> first_soft_, first_hard_, first_segment_;  // by pixel
  std::vector<Stretch> soft_, hard_;                          // of one pixel
};

}  // namespace sinew
