#include "sinew/contact/depth_view.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr int kMaxStretches = 64;  // of a ray through one body
constexpr double kFar = 1e6;       // m

struct Point2 {
  double u, v;
};

/// Which side of the line from a to b the point p is on: 1 left, -1 right. A point on the line counts as moved by
/// (epsilon, epsilon^2), so that surfaces have neither gaps nor double layers along edges and at corners.
int calcSide(const Point2& a, const Point2& b, const Point2& p) {
  const double du = b.u - a.u, dv = b.v - a.v;
  const double cross = du * (p.v - a.v) - dv * (p.u - a.u);
  if (cross != 0) return cross > 0 ? 1 : -1;
  if (dv != 0) return dv < 0 ? 1 : -1;
  return du > 0 ? 1 : -1;
}

/// The same with the ends in an order that both triangles of the edge share.
int calcSideOrdered(int index_a, const Point2& a, int index_b, const Point2& b, const Point2& p) {
  return index_a < index_b ? calcSide(a, b, p) : -calcSide(b, a, p);
}

double calcCross(const Point2& a, const Point2& b, const Point2& c) {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

}  // namespace

DepthView::DepthView(int axis, int pixels, int max_layers)
    : axis_(axis), u_((axis + 1) % 3), v_((axis + 2) % 3), pixels_(pixels) {
  const int count = pixels * pixels;
  layers_.reserve(max_layers);
  segments_.reserve(max_layers);
  first_soft_.resize(count);
  first_hard_.resize(count);
  first_segment_.resize(count + 1);
  soft_.reserve(kMaxStretches);
  hard_.reserve(kMaxStretches);
}

void DepthView::clear() {
  layers_.clear();
  segments_.clear();
  std::fill(first_segment_.begin(), first_segment_.end(), 0);
}

void DepthView::start(const Box& box) {
  box_ = box;
  lower_u_ = box.lower[u_];
  lower_v_ = box.lower[v_];
  step_u_ = (box.upper[u_] - lower_u_) / pixels_;
  step_v_ = (box.upper[v_] - lower_v_) / pixels_;
  step_depth_ = (box.upper[axis_] - box.lower[axis_]) / pixels_;
  has_room_ = true;
  layers_.clear();
  segments_.clear();
}

bool DepthView::update(const MovingSurface& soft, const ObstacleShape& obstacle, double dilation, const Pose& pose,
                       const Box& box) {
  start(box);
  rasterise(soft, first_soft_);
  const Pose to_shape = pose.inverse(Eigen::Isometry);
  for (int pixel = 0; pixel < pixels_ * pixels_; ++pixel) {
    first_segment_[pixel] = static_cast<int>(segments_.size());
    if (first_soft_[pixel] < 0) continue;
    hard_.clear();
    addChord(pixel, obstacle, dilation, to_shape);
    intersect(pixel);
  }
  first_segment_.back() = static_cast<int>(segments_.size());
  return has_room_;
}

bool DepthView::update(const MovingSurface& soft, const MovingSurface& obstacle, const Box& box) {
  start(box);
  rasterise(soft, first_soft_);
  rasterise(obstacle, first_hard_);
  for (int pixel = 0; pixel < pixels_ * pixels_; ++pixel) {
    first_segment_[pixel] = static_cast<int>(segments_.size());
    if (first_soft_[pixel] < 0) continue;
    collectStretches(first_hard_[pixel], false, hard_);
    intersect(pixel);
  }
  first_segment_.back() = static_cast<int>(segments_.size());
  return has_room_;
}

void DepthView::rasterise(const MovingSurface& surface, std::vector<int>& first_layer) {
  std::fill(first_layer.begin(), first_layer.end(), -1);
  Box column = box_;
  column.lower[axis_] = -kFar;
  column.upper[axis_] = kFar;
  surface.tree().forEachIn(column, [&](int triangle) { addTriangle(surface, triangle, first_layer); });
}

int DepthView::calcPixel(double value, double lower, double step) const {
  const double at = std::floor((value - lower) / step);
  return static_cast<int>(std::min(std::max(at, 0.0), pixels_ - 1.0));
}

void DepthView::addTriangle(const MovingSurface& surface, int triangle, std::vector<int>& first_layer) {
  const auto& index = surface.topology().triangles()[triangle];
  Point2 x[3];
  Vec3 depths;
  for (int i = 0; i < 3; ++i) {
    const Vec3& corner = surface.corner(triangle, i);
    x[i] = {corner[u_], corner[v_]};
    depths[i] = corner[axis_];
  }
  const double doubled = calcCross(x[0], x[1], x[2]);
  if (doubled == 0) return;
  const int turn = doubled > 0 ? 1 : -1;
  const int i0 = calcPixel(std::min({x[0].u, x[1].u, x[2].u}), lower_u_, step_u_);
  const int i1 = calcPixel(std::max({x[0].u, x[1].u, x[2].u}), lower_u_, step_u_);
  const int j0 = calcPixel(std::min({x[0].v, x[1].v, x[2].v}), lower_v_, step_v_);
  const int j1 = calcPixel(std::max({x[0].v, x[1].v, x[2].v}), lower_v_, step_v_);
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) {
      const Point2 p = {lower_u_ + (i + 0.5) * step_u_, lower_v_ + (j + 0.5) * step_v_};
      const bool is_inside = calcSideOrdered(index[0], x[0], index[1], x[1], p) == turn &&
                             calcSideOrdered(index[1], x[1], index[2], x[2], p) == turn &&
                             calcSideOrdered(index[2], x[2], index[0], x[0], p) == turn;
      if (!is_inside) continue;
      const Vec3 weights = Vec3(calcCross(x[1], x[2], p), calcCross(x[2], x[0], p), calcCross(x[0], x[1], p)) / doubled;
      addLayer(i + pixels_ * j, {weights.dot(depths), triangle, weights, turn < 0, -1}, first_layer);
    }
  }
}

void DepthView::addLayer(int pixel, const Layer& layer, std::vector<int>& first_layer) {
  if (layers_.size() == layers_.capacity()) {
    has_room_ = false;
    return;
  }
  int* link = &first_layer[pixel];
  while (*link >= 0 && layers_[*link].depth < layer.depth) link = &layers_[*link].next;
  const int next = *link;
  *link = static_cast<int>(layers_.size());
  layers_.push_back(layer);
  layers_.back().next = next;
}

void DepthView::collectStretches(int first_layer, bool is_soft, std::vector<Stretch>& stretches) {
  stretches.clear();
  int inside = 0;
  Stretch stretch{};
  for (int i = first_layer; i >= 0; i = layers_[i].next) {
    const bool was_inside = inside > 0;
    inside += layers_[i].is_front ? 1 : -1;
    const bool is_inside = inside > 0;
    if (is_inside && !was_inside) {
      stretch.begin = layers_[i].depth;
      stretch.begin_layer = is_soft ? i : -1;
    } else if (was_inside && !is_inside && stretches.size() < stretches.capacity()) {
      stretch.end = layers_[i].depth;
      stretch.end_layer = is_soft ? i : -1;
      stretches.push_back(stretch);
    }
  }
}

void DepthView::addChord(int pixel, const ObstacleShape& obstacle, double dilation, const Pose& to_shape) {
  double enter, leave;
  const Vec3 direction = to_shape.linear().col(axis_);
  if (!obstacle.calcChord(to_shape * calcPoint(pixel, 0), direction, dilation, &enter, &leave)) return;
  if (leave > enter) hard_.push_back({enter, leave, -1, -1});
}

void DepthView::intersect(int pixel) {
  collectStretches(first_soft_[pixel], true, soft_);
  std::size_t i = 0, j = 0;
  while (i < soft_.size() && j < hard_.size()) {
    const Stretch& soft = soft_[i];
    const Stretch& hard = hard_[j];
    const bool begins_soft = soft.begin > hard.begin;
    const bool ends_soft = soft.end < hard.end;
    const Segment segment = {pixel, std::max(soft.begin, hard.begin), std::min(soft.end, hard.end),
                             begins_soft ? soft.begin_layer : -1, ends_soft ? soft.end_layer : -1};
    if (segment.end > segment.begin) {
      if (segments_.size() < segments_.capacity()) {
        segments_.push_back(segment);
      } else {
        has_room_ = false;
      }
    }
    ++(ends_soft ? i : j);
  }
}

Vec3 DepthView::calcPoint(int pixel, double depth) const {
  const int row = pixel / pixels_, column = pixel % pixels_;
  Vec3 point;
  point[axis_] = depth;
  point[u_] = lower_u_ + (column + 0.5) * step_u_;
  point[v_] = lower_v_ + (row + 0.5) * step_v_;
  return point;
}

Vec3 DepthView::calcMiddle(const Segment& segment) const {
  return calcPoint(segment.pixel, (segment.begin + segment.end) / 2);
}

int DepthView::findSegment(const Vec3& point) const {
  const int pixel = calcPixel(point[u_], lower_u_, step_u_) + pixels_ * calcPixel(point[v_], lower_v_, step_v_);
  for (int s = first_segment_[pixel]; s < first_segment_[pixel + 1]; ++s) {
    const double depth = point[axis_];
    if (segments_[s].begin - step_depth_ <= depth && depth <= segments_[s].end + step_depth_) return s;
  }
  return -1;
}

}  // namespace sinew
