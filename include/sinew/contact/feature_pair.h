#pragma once

#include <algorithm>
#include <cstdint>

#include "sinew/contact/contact_list.h"
#include "sinew/contact/moving_surface.h"

namespace sinew {

/// What meets what: on the robot, on the obstacle. In self-contact a vertex comes before an edge before a face, and of
/// two alike the smaller index.
enum class PairKind {
  kVertexSmooth,
  kEdgeSmooth,
  kFaceSmooth,
  kFaceRim,
  kVertexFace,
  kFaceVertex,
  kEdgeEdge,
  kVertexEdge,
  kEdgeVertex,
  kVertexVertex,
  kVolume
};

/// Obstacle, kind, feature of the robot and of the other side in one number, ordered so.
inline std::uint64_t makeContactKey(int obstacle, PairKind kind, int a, int b) {
  constexpr int kFeatureBits = 25;
  constexpr int kKindBits = 4;
  std::uint64_t key = static_cast<std::uint64_t>(obstacle - kOtherSurface);
  key = (key << kKindBits) | static_cast<std::uint64_t>(kind);
  key = (key << kFeatureBits) | static_cast<std::uint64_t>(a);
  return (key << kFeatureBits) | static_cast<std::uint64_t>(b);
}

inline PairKind kindOf(std::uint64_t key) {
  return static_cast<PairKind>((key >> 50) & 15);
}

/// A point of a surface as a mean of one to three of its vertices.
struct SurfacePoint {
  int vertices = 0;
  int vertex[3];
  double weight[3];
  Vec3 position;

  static SurfacePoint atVertex(const MovingSurface& surface, int vertex);
  static SurfacePoint onEdge(const MovingSurface& surface, int edge, double t);
  static SurfacePoint onFace(const MovingSurface& surface, int triangle, const Vec3& weights);
  Vec3 calcRestPosition(const MovingSurface& surface) const;
};

/// Sine of the bend from which an edge counts as one.
constexpr double kLeastBend = 0.02;

/// When a pair of features becomes a contact.
struct ProximitySettings {
  double contact_distance = 1e-3;  ///< m, distance at which the gap is 0
  double alarm_distance = 5e-3;    ///< m, distance below which pairs are kept
  double slope = 0.3;              ///< relative motion of neighbouring points per distance, see ProximityDetection
  double max_depth = 2e-3;         ///< m, how deep two triangle surfaces may be in each other and still be pushed apart
  double hysteresis = 0.1;         ///< part by which alarm distance and slope grow for a pair that was kept before

  /// Throws ConfigError.
  void check() const;
};

/// Pairs that pass alarm distance and slope, narrowly for new ones, widely for those of the cycle before.
class PairFilter {
 public:
  explicit PairFilter(const ProximitySettings& settings)
      : alarm_(settings.alarm_distance),
        slope_(settings.slope),
        widening_(1 + settings.hysteresis),
        max_depth_(settings.max_depth) {}

  double widestAlarm() const { return alarm_ * widening_; }
  /// No pair farther apart, outside or inside, is kept [m].
  double reach() const { return std::max(widestAlarm(), max_depth_); }
  double widestSlope() const { return slope_ * widening_; }
  bool accepts(double distance, double slope, std::uint64_t key, const ContactList& list) const {
    if (distance <= alarm_ && slope >= -slope_) return true;
    return distance <= widestAlarm() && slope >= -widestSlope() && list.hadRow(key);
  }

 private:
  double alarm_, slope_, widening_, max_depth_;
};

}  // namespace sinew
