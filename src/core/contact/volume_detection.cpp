#include "sinew/contact/volume_detection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "sinew/common/config_error.h"
#include "sinew/contact/feature_pair.h"

namespace sinew {
namespace {

constexpr int kLayersPerPixel = 8;
constexpr double kSmallest = 1e-9;   // m, an overlap of boxes thinner than that is none
constexpr double kLeastPart = 0.25;  // of the covered area that counts as overlap where the surface's normals cancel
constexpr double kLeastShare = 0.1;  // likewise of a view, in its part of the row

/// Moves each vertex so that its faces move outwards by `margin`, in the least-squares sense; no farther than twice
/// that.
std::vector<Vec3> calcDilated(const MeshDistance& mesh, double margin) {
  const auto& triangles = mesh.surface().triangles();
  std::vector<Mat3> normal_products(mesh.vertices().size(), 1e-9 * Mat3::Identity());
  std::vector<Vec3> sums(mesh.vertices().size(), Vec3::Zero());
  for (const auto& t : triangles) {
    const auto& x = mesh.vertices();
    const Vec3 normal = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
    for (const int corner : t) {
      normal_products[corner] += normal * normal.transpose();
      sums[corner] += normal;
    }
  }
  std::vector<Vec3> dilated = mesh.vertices();
  for (std::size_t v = 0; v < dilated.size(); ++v) {
    const Vec3 offset = margin * Vec3(normal_products[v].ldlt().solve(sums[v]));
    dilated[v] += offset * std::min(1.0, 2 * margin / offset.norm());
  }
  return dilated;
}

void require(bool holds, const char* name, double found, const char* expected) {
  if (!holds || !std::isfinite(found)) {
    throw ConfigError(std::string("volume detection: ") + name, std::to_string(found), expected);
  }
}

}  // namespace

void VolumeSettings::check() const {
  require(contact_distance > 0, "contact_distance", contact_distance, "greater than 0 m");
  require(sharpness >= 0 && sharpness <= 100, "sharpness", sharpness, "0 to 100");
  const double most = contact_distance * (sharpness + 3) / 2;
  require(dilation > contact_distance && dilation <= most * (1 + 1e-9), "dilation", dilation,
          ("more than the contact distance and at most " + std::to_string(most)).c_str());
  require(pixels >= 2 && pixels <= 512, "pixels", pixels, "2 to 512");
  require(vanish >= 0 && vanish <= appear && appear < 1, "appear", appear, "between vanish and 1");
}

VolumeDetection::VolumeDetection(const VolumeSettings& settings, const CollisionSurface& topology,
                                 const std::vector<ObstacleShape>& obstacles, int max_regions)
    : settings_(settings), max_regions_(max_regions) {
  settings.check();
  for (const ObstacleShape& shape : obstacles) {
    Obstacle obstacle = {shape, nullptr, {}};
    if (shape.mesh() != nullptr) {
      obstacle.surface = std::make_unique<MovingSurface>(CollisionSurface(shape.mesh()->surface().triangles()),
                                                         calcDilated(*shape.mesh(), settings.dilation));
    }
    obstacle.previous.reserve(max_regions);
    obstacles_.push_back(std::move(obstacle));
  }
  const int max_layers = kLayersPerPixel * settings.pixels * settings.pixels;
  for (int axis = 0; axis < 3; ++axis) views_.emplace_back(axis, settings.pixels, max_layers);
  parent_.reserve(3 * max_layers);
  region_of_.reserve(3 * max_layers);
  sums_.reserve(max_regions);
  weighted_sums_.reserve(max_regions);
  regions_.reserve(max_regions);
  is_taken_.reserve(max_regions);
  gradient_.assign(topology.vertices(), Vec3::Zero());
  is_touched_.assign(topology.vertices(), 0);
  touched_.reserve(topology.vertices());
  entries_.reserve(topology.vertices());
}

bool VolumeDetection::addObstacle(const MovingSurface& surface, int index, const Pose& pose, ContactList& list) {
  Obstacle& obstacle = obstacles_[index];
  regions_.clear();
  bool has_room = updateViews(surface, obstacle, pose);
  joinSegments();
  has_room = collectRegions() && has_room;
  weighRegions();
  nameRegions(obstacle);
  for (int region = 0; region < static_cast<int>(regions_.size()); ++region) addRow(surface, index, region, list);
  return has_room;
}

Box VolumeDetection::calcObstacleBox(const Obstacle& obstacle, const Pose& pose) const {
  if (obstacle.surface != nullptr) return obstacle.surface->tree().box();
  const double corner = obstacle.shape.kind() == ObstacleShape::Kind::kSphere ? 1 : std::sqrt(3.0);
  const bool is_aligned = (pose.linear().cwiseAbs().rowwise().maxCoeff().array() == 1).all();
  return obstacle.shape.calcBox(pose).grown(settings_.dilation * (is_aligned ? 1 : corner));
}

bool VolumeDetection::updateViews(const MovingSurface& surface, Obstacle& obstacle, const Pose& pose) {
  if (obstacle.surface != nullptr) obstacle.surface->updateRigid(pose);
  Box overlap = calcObstacleBox(obstacle, pose);
  overlap.lower = overlap.lower.cwiseMax(surface.tree().box().lower);
  overlap.upper = overlap.upper.cwiseMin(surface.tree().box().upper);
  const bool is_empty = (overlap.upper - overlap.lower).minCoeff() < kSmallest;
  bool has_room = true;
  for (DepthView& view : views_) {
    if (is_empty) {
      view.clear();
    } else if (obstacle.surface != nullptr) {
      has_room = view.update(surface, *obstacle.surface, overlap) && has_room;
    } else {
      has_room = view.update(surface, obstacle.shape, settings_.dilation, pose, overlap) && has_room;
    }
  }
  return has_room;
}

int VolumeDetection::find(int segment) {
  while (parent_[segment] != segment) {
    parent_[segment] = parent_[parent_[segment]];
    segment = parent_[segment];
  }
  return segment;
}

void VolumeDetection::join(int a, int b) {
  const int root_a = find(a), root_b = find(b);
  parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

void VolumeDetection::joinSegments() {
  for (int k = 0; k < 3; ++k) first_[k + 1] = first_[k] + static_cast<int>(views_[k].segments().size());
  parent_.resize(first_[3]);
  std::iota(parent_.begin(), parent_.end(), 0);
  for (int k = 0; k < 3; ++k) {
    if (views_[k].segments().empty()) continue;
    const int side = views_[k].pixels();
    for (int pixel = 0; pixel < side * side; ++pixel) {
      if (pixel % side > 0) joinPixels(views_[k], first_[k], pixel, pixel - 1);
      if (pixel >= side) joinPixels(views_[k], first_[k], pixel, pixel - side);
    }
    joinViews(k);
  }
}

void VolumeDetection::joinPixels(const DepthView& view, int first, int pixel, int other) {
  for (int i = view.firstSegment(pixel); i < view.firstSegment(pixel + 1); ++i) {
    for (int j = view.firstSegment(other); j < view.firstSegment(other + 1); ++j) {
      if (view.areJoined(view.segments()[i], view.segments()[j])) join(first + i, first + j);
    }
  }
}

void VolumeDetection::joinViews(int k) {
  for (int i = 0; i < static_cast<int>(views_[k].segments().size()); ++i) {
    const Vec3 middle = views_[k].calcMiddle(views_[k].segments()[i]);
    for (int other = 0; other < 3; ++other) {
      if (other == k || views_[other].segments().empty()) continue;
      const int j = views_[other].findSegment(middle);
      if (j >= 0) join(first_[k] + i, first_[other] + j);
    }
  }
}

bool VolumeDetection::collectRegions() {
  sums_.clear();
  region_of_.assign(parent_.size(), -1);
  for (int k = 0; k < 3; ++k) {
    for (int i = first_[k]; i < first_[k + 1]; ++i) {
      const int root = find(i);
      if (region_of_[root] < 0 && static_cast<int>(sums_.size()) < max_regions_) {
        region_of_[root] = static_cast<int>(sums_.size());
        sums_.push_back(Sum());
      }
      region_of_[i] = region_of_[root];
      if (region_of_[i] >= 0) addToSum(views_[k], views_[k].segments()[i - first_[k]], 1, sums_[region_of_[i]]);
    }
  }
  for (const Sum& sum : sums_) regions_.push_back(makeRegion(sum));
  return std::find(region_of_.begin(), region_of_.end(), -1) == region_of_.end();
}

double VolumeDetection::calcWeight(int k, const DepthView::Segment& segment, int region) const {
  return std::pow((segment.end - segment.begin) / sums_[region].longest[k], settings_.sharpness);
}

void VolumeDetection::weighRegions() {
  weighted_sums_.assign(sums_.size(), Sum());
  for (int k = 0; k < 3; ++k) {
    for (int i = first_[k]; i < first_[k + 1]; ++i) {
      const int region = region_of_[i];
      if (region < 0) continue;
      const DepthView::Segment& segment = views_[k].segments()[i - first_[k]];
      addToSum(views_[k], segment, calcWeight(k, segment, region), weighted_sums_[region]);
    }
  }
}

double VolumeDetection::calcDepth(int region) const {
  const Sum& sum = weighted_sums_[region];
  const Vec3 normal = regions_[region].boundary.normalized();
  double depth = 0;
  for (int k = 0; k < 3; ++k) {
    if (sum.covered[k] > 0) depth += std::pow(std::abs(normal[k]), 3) * sum.volume[k] / sum.covered[k];
  }
  return depth;
}

// What turns the sums of each view into the part of the normal along its axis.
Vec3 VolumeDetection::calcShares(int region) const {
  const Sum& sum = weighted_sums_[region];
  const Vec3 normal = regions_[region].boundary.normalized();
  Vec3 shares = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double least = kLeastShare * std::abs(normal[k]) * sum.covered[k];
    if (least > 0) shares[k] = std::abs(normal[k]) / std::max(least, std::abs(sum.boundary[k]));
  }
  return shares;
}

void VolumeDetection::addToSum(const DepthView& view, const DepthView::Segment& segment, double weight, Sum& sum) {
  const int k = view.axis();
  const double area = weight * view.pixelArea();
  const double volume = area * (segment.end - segment.begin);
  const Vec3 middle = view.calcMiddle(segment);
  Vec3 begin = middle, end = middle;
  begin[k] = segment.begin;
  end[k] = segment.end;
  sum.volume[k] += volume;
  sum.covered[k] += area;
  sum.longest[k] = std::max(sum.longest[k], segment.end - segment.begin);
  sum.moment += volume * middle;
  sum.weight += volume;
  sum.box.extend(begin);
  sum.box.extend(end);
  if (segment.begin_layer >= 0) sum.boundary[k] -= area;
  if (segment.end_layer >= 0) sum.boundary[k] += area;
}

VolumeRegion VolumeDetection::makeRegion(const Sum& sum) const {
  VolumeRegion region;
  region.boundary = sum.boundary;
  const double squared = sum.boundary.squaredNorm();
  Vec3 weights = Vec3::Constant(1.0 / 3);
  if (squared > 0) weights = sum.boundary.cwiseAbs2() / squared;
  const double most = *std::max_element(sum.covered.begin(), sum.covered.end());
  for (int k = 0; k < 3; ++k) region.volume += weights[k] * sum.volume[k];
  region.area = std::max(std::sqrt(squared), kLeastPart * most);
  region.centre = sum.moment / sum.weight;
  region.extent = (sum.box.upper - sum.box.lower) / 2;
  return region;
}

// A region keeps the name of the nearest one of the cycle before whose centre it could have reached.
void VolumeDetection::nameRegions(Obstacle& obstacle) {
  is_taken_.assign(max_regions_, 0);
  for (VolumeRegion& region : regions_) {
    region.id = -1;
    double least = 1e300;
    for (const VolumeRegion& previous : obstacle.previous) {
      const double distance = (previous.centre - region.centre).norm();
      const double reach = previous.extent.norm() + region.extent.norm();
      if (is_taken_[previous.id] || distance > reach || distance >= least) continue;
      least = distance;
      region.id = previous.id;
    }
    if (region.id >= 0) is_taken_[region.id] = 1;
  }
  for (VolumeRegion& region : regions_) {
    if (region.id >= 0) continue;
    region.id = static_cast<int>(std::find(is_taken_.begin(), is_taken_.end(), 0) - is_taken_.begin());
    is_taken_[region.id] = 1;
  }
  obstacle.previous = regions_;
}

void VolumeDetection::addRow(const MovingSurface& surface, int obstacle, int index, ContactList& list) {
  const VolumeRegion& region = regions_[index];
  ContactRow row;
  row.key = makeContactKey(obstacle, PairKind::kVolume, region.id, 0);
  const double thickness = calcDepth(index);
  const double least = list.hadRow(row.key) ? settings_.vanish : settings_.appear;
  if (region.boundary.norm() == 0 || thickness < least * settings_.dilation) return;
  row.obstacle = obstacle;
  row.method = ContactMethod::kVolume;
  row.normal = -region.boundary.normalized();
  row.point = region.centre - thickness / 2 * row.normal;
  row.other_point = region.centre + (thickness / 2 - settings_.dilation) * row.normal;
  row.gap = settings_.dilation - settings_.contact_distance - thickness;
  row.area = region.area;

  collectGradient(surface, index);
  const Vec3 shares = calcShares(index);
  entries_.clear();
  for (const int vertex : touched_) {
    entries_.push_back({0, surface.topology().node(vertex), -gradient_[vertex].cwiseProduct(shares)});
    gradient_[vertex].setZero();
    is_touched_[vertex] = 0;
  }
  touched_.clear();
  list.add(row, entries_.data(), static_cast<int>(entries_.size()));
}

void VolumeDetection::collectGradient(const MovingSurface& surface, int region) {
  for (int k = 0; k < 3; ++k) {
    for (int i = first_[k]; i < first_[k + 1]; ++i) {
      if (region_of_[i] != region) continue;
      const DepthView::Segment& segment = views_[k].segments()[i - first_[k]];
      const double area = calcWeight(k, segment, region) * views_[k].pixelArea();
      addGradient(surface, views_[k], segment.begin_layer, -area);
      addGradient(surface, views_[k], segment.end_layer, area);
    }
  }
  std::sort(touched_.begin(), touched_.end());
}

void VolumeDetection::addGradient(const MovingSurface& surface, const DepthView& view, int layer, double factor) {
  if (layer < 0) return;
  const DepthView::Layer& hit = view.layer(layer);
  for (int i = 0; i < 3; ++i) {
    const int vertex = surface.topology().triangles()[hit.triangle][i];
    gradient_[vertex][view.axis()] += factor * hit.weights[i];
    if (!is_touched_[vertex]) touched_.push_back(vertex);
    is_touched_[vertex] = 1;
  }
}

}  // namespace sinew
