#include "visualization_node_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "ros_conversions.h"

namespace sinew {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

const Colour kEffectorColour(0.10, 0.75, 0.35, 1.0);
const Colour kTargetColour(0.98, 0.55, 0.05, 0.9);
const Colour kErrorColour(0.95, 0.25, 0.55, 1.0);
const Colour kLimitColour(0.90, 0.05, 0.05, 1.0);

constexpr double kAmbient = 0.55;
constexpr double kKey = 0.52;
constexpr double kFill = 0.22;

// Strokes as parts of the body's extent.
constexpr double kCableRadius = 0.0045;
constexpr double kPullPointRadius = 0.011;
constexpr double kEffectorRadius = 0.016;
constexpr double kTargetRadius = 0.018;
constexpr double kErrorWidth = 0.006;
constexpr double kTextHeight = 0.045;
constexpr int kTubeSides = 8;

// Markers vanish by themselves when nobody refreshes them.
const ros::Duration kLifetime(1.0);

Vec3 toVec3(const geometry_msgs::Point32& point) {
  return Vec3(point.x, point.y, point.z);
}

Marker makeSpheres(const std_msgs::Header& header, const std::string& name, double radius, const Colour& colour) {
  Marker marker = makeMarker(header, name, 0, Marker::SPHERE_LIST);
  marker.scale.x = marker.scale.y = marker.scale.z = 2 * radius;
  marker.color = toRgba(colour);
  return marker;
}

Marker makeLines(const std_msgs::Header& header, const std::string& name, double width, const Colour& colour) {
  Marker marker = makeMarker(header, name, 0, Marker::LINE_LIST);
  marker.scale.x = width;
  marker.color = toRgba(colour);
  return marker;
}

std::vector<Vec3> calcVertices(const BodyState& body) {
  std::vector<Vec3> vertices;
  vertices.reserve(body.vertices.size());
  for (const auto& vertex : body.vertices) vertices.push_back(toVec3(vertex));
  return vertices;
}

/// Area-weighted mean of the normals around each vertex.
std::vector<Vec3> calcNormals(const BodyState& body, const std::vector<Vec3>& vertices) {
  std::vector<Vec3> normals(vertices.size(), Vec3::Zero());
  const auto& t = body.triangles;
  for (size_t i = 0; i + 2 < t.size(); i += 3) {
    const Vec3 normal = (vertices[t[i + 1]] - vertices[t[i]]).cross(vertices[t[i + 2]] - vertices[t[i]]);
    for (size_t corner = i; corner < i + 3; ++corner) normals[t[corner]] += normal;
  }
  for (Vec3& normal : normals) normal.normalize();
  return normals;
}

void addVertex(const Vec3& point, const Colour& colour, Marker& marker) {
  marker.points.push_back(toPoint(point));
  marker.colors.push_back(toRgba(colour));
}

void addSurface(const BodyState& body, const BodyStyle& style, const Light& light, MarkerArray& markers) {
  const std::vector<Vec3> vertices = calcVertices(body);
  const std::vector<Vec3> normals = calcNormals(body, vertices);
  Marker marker = makeMarker(body.header, style.name + "body", 0, Marker::TRIANGLE_LIST);
  for (const uint32_t i : body.triangles) addVertex(vertices[i], light.calcShade(normals[i], style.silicone), marker);
  marker.color.a = static_cast<float>(style.silicone[3]);
  markers.markers.push_back(std::move(marker));
}

void addEdges(const BodyState& body, const BodyStyle& style, double extent, MarkerArray& markers) {
  Marker marker = makeLines(body.header, style.name + "edges", 0.0012 * extent, style.edges);
  std::set<std::pair<uint32_t, uint32_t>> edges;
  const auto& t = body.triangles;
  for (size_t i = 0; i + 2 < t.size(); i += 3) {
    for (size_t k = 0; k < 3; ++k) edges.insert(std::minmax(t[i + k], t[i + (k + 1) % 3]));
  }
  for (const auto& [from, to] : edges) {
    marker.points.push_back(toPoint(toVec3(body.vertices[from])));
    marker.points.push_back(toPoint(toVec3(body.vertices[to])));
  }
  markers.markers.push_back(std::move(marker));
}

/// The side wall of a cylinder around the segment from `a` to `b`.
void addTube(const Vec3& a, const Vec3& b, double radius, const Colour& colour, const Light& light, Marker& marker) {
  if ((b - a).norm() < 1e-9) return;
  const Vec3 u = (b - a).unitOrthogonal();
  const Vec3 v = (b - a).normalized().cross(u);
  const auto calcNormal = [&](int side) {
    const double angle = 2 * M_PI * side / kTubeSides;
    return Vec3(std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int side = 0; side < kTubeSides; ++side) {
    const Vec3 n0 = calcNormal(side), n1 = calcNormal(side + 1);
    const Colour shade0 = light.calcShade(n0, colour), shade1 = light.calcShade(n1, colour);
    addVertex(a + radius * n0, shade0, marker);
    addVertex(a + radius * n1, shade1, marker);
    addVertex(b + radius * n1, shade1, marker);
    addVertex(a + radius * n0, shade0, marker);
    addVertex(b + radius * n1, shade1, marker);
    addVertex(b + radius * n0, shade0, marker);
  }
}

/// Root of tension over its limit: tells small tensions apart, and is 1 at the limit.
double calcTensionRatio(const BodyState& body, size_t cable) {
  const double most = body.cable_tension_max[cable];
  if (!std::isfinite(most) || most <= 0) return 0;
  return std::sqrt(std::min(1.0, std::max(0.0, body.cable_tension[cable] / most)));
}

void addCables(const BodyState& body, const BodyStyle& style, const Light& light, double extent, MarkerArray& markers) {
  Marker tubes = makeMarker(body.header, style.name + "cables", 0, Marker::TRIANGLE_LIST);
  Marker heads = makeSpheres(body.header, style.name + "pull_points", kPullPointRadius * extent, Colour::Ones());
  size_t first = 0;
  for (size_t cable = 0; cable < body.cable.size(); ++cable) {
    const Colour colour = calcTensionColour(calcTensionRatio(body, cable));
    const size_t end = first + body.cable_size[cable];
    for (size_t i = first; i + 1 < end; ++i) {
      addTube(toVec3(body.cable_points[i]), toVec3(body.cable_points[i + 1]), kCableRadius * extent, colour, light,
              tubes);
    }
    if (first < end) addVertex(toVec3(body.cable_points[first]), colour, heads);
    first = end;
  }
  if (!tubes.points.empty()) markers.markers.push_back(std::move(tubes));
  if (!heads.points.empty()) markers.markers.push_back(std::move(heads));
}

std::string describe(const ActiveLimit& limit) {
  static const std::array<const char*, 6> kWords{
      {"fully paid out", "fully reeled in", "slack", "tension limit", "rate limit, out", "rate limit, in"}};
  std::ostringstream text;
  text << limit.actuator << ": " << (limit.kind < kWords.size() ? kWords[limit.kind] : "limit");
  if (limit.violation > 0) text << " exceeded";
  return text.str();
}

/// Mean of the pull points [m].
Vec3 calcPullCentre(const BodyState& body) {
  Vec3 sum = Vec3::Zero();
  size_t first = 0;
  for (const uint32_t size : body.cable_size) {
    if (size > 0) sum += toVec3(body.cable_points[first]);
    first += size;
  }
  return sum / std::max<double>(1, static_cast<double>(body.cable_size.size()));
}

/// Beside the body, on the side of the pull point.
Vec3 calcTextPlace(const Vec3& centre, const Vec3& pull_point, double extent) {
  const Vec3 arm = pull_point - centre;
  return arm.norm() > 1e-9 ? Vec3(pull_point + 0.35 * extent * arm.normalized()) : pull_point;
}

/// A cable that is slack is at rest, not in trouble.
bool isWorthShowing(const ActiveLimit& limit) {
  return limit.kind != ActiveLimit::EFFORT_MIN;
}

}  // namespace

std_msgs::ColorRGBA toRgba(const Colour& colour) {
  std_msgs::ColorRGBA message;
  message.r = static_cast<float>(colour[0]);
  message.g = static_cast<float>(colour[1]);
  message.b = static_cast<float>(colour[2]);
  message.a = static_cast<float>(colour[3]);
  return message;
}

Marker makeMarker(const std_msgs::Header& header, const std::string& name, int id, int type) {
  Marker marker;
  marker.header.frame_id = header.frame_id;  // stamp zero: newest transform
  marker.ns = name;
  marker.id = id;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.scale.x = marker.scale.y = marker.scale.z = 1;
  marker.color = toRgba(Colour::Ones());
  marker.lifetime = kLifetime;
  return marker;
}

Colour Light::calcShade(const Vec3& normal, const Colour& base) const {
  const double brightness = kAmbient + kKey * std::max(0.0, normal.dot(key)) + kFill * std::max(0.0, normal.dot(fill));
  // A soft highlight, the glint of moulded silicone.
  const double glint = 0.18 * std::pow(std::max(0.0, normal.dot(key)), 12);
  Colour colour;
  colour.head<3>() = (brightness * base.head<3>() + Vec3::Constant(glint)).cwiseMin(1.0);
  colour[3] = base[3];
  return colour;
}

Light Light::seenFrom(const Mat3& axes) const {
  Light light;
  light.key = axes.transpose() * key;
  light.fill = axes.transpose() * fill;
  return light;
}

bool isConsistent(const BodyState& body) {
  const size_t cables = body.cable.size();
  if (body.header.frame_id.empty() || body.vertices.empty() || body.triangles.size() % 3 != 0) return false;
  if (body.cable_size.size() != cables || body.cable_tension.size() != cables) return false;
  if (body.cable_tension_max.size() != cables) return false;
  size_t points = 0;
  for (const uint32_t size : body.cable_size) points += size;
  return points == body.cable_points.size() && std::all_of(body.triangles.begin(), body.triangles.end(),
                                                           [&](uint32_t i) { return i < body.vertices.size(); });
}

double calcExtent(const BodyState& body) {
  Eigen::AlignedBox3d box;
  for (const auto& vertex : body.vertices) box.extend(toVec3(vertex));
  return box.diagonal().norm();
}

Colour calcTensionColour(double ratio) {
  static const std::array<Vec3, 5> kScale{{Vec3(0.13, 0.30, 0.85), Vec3(0.10, 0.62, 0.80), Vec3(0.30, 0.75, 0.30),
                                           Vec3(0.95, 0.75, 0.10), Vec3(0.88, 0.12, 0.08)}};
  const double place = std::min(1.0, std::max(0.0, ratio)) * (kScale.size() - 1);
  const size_t lower = std::min(kScale.size() - 2, static_cast<size_t>(place));
  const double part = place - static_cast<double>(lower);
  Colour colour;
  colour << (1 - part) * kScale[lower] + part * kScale[lower + 1], 1;
  return colour;
}

void addBody(const BodyState& body, const BodyStyle& style, const Light& light, double extent, MarkerArray& markers) {
  addSurface(body, style, light, markers);
  if (style.edges[3] > 0) addEdges(body, style, extent, markers);
  if (style.cables) addCables(body, style, light, extent, markers);
}

void addEffectors(const ControllerState& state, double extent, MarkerArray& markers) {
  Marker effectors = makeSpheres(state.header, "effectors", kEffectorRadius * extent, kEffectorColour);
  Marker targets = makeSpheres(state.header, "targets", kTargetRadius * extent, kTargetColour);
  Marker errors = makeLines(state.header, "effector_errors", kErrorWidth * extent, kErrorColour);
  for (const EffectorState& effector : state.effectors) {
    effectors.points.push_back(effector.position);
    if (state.status == ControllerState::DISABLED || !effector.targeted) continue;
    targets.points.push_back(effector.target);
    errors.points.push_back(effector.position);
    errors.points.push_back(effector.target);
  }
  for (Marker* marker : {&effectors, &targets, &errors}) {
    if (!marker->points.empty()) markers.markers.push_back(std::move(*marker));
  }
}

void addLimits(const ControllerState& state, const BodyState& body, double extent, MarkerArray& markers) {
  Marker heads = makeSpheres(body.header, "limit_heads", 1.5 * kPullPointRadius * extent, kLimitColour);
  const Vec3 centre = calcPullCentre(body);
  int id = 0;
  for (const ActiveLimit& limit : state.limits) {
    if (!isWorthShowing(limit)) continue;
    size_t first = 0;
    for (size_t cable = 0; cable < body.cable.size(); first += body.cable_size[cable++]) {
      if (body.cable[cable] != limit.actuator || body.cable_size[cable] == 0) continue;
      const geometry_msgs::Point head = toPoint(toVec3(body.cable_points[first]));
      heads.points.push_back(head);
      Marker text = makeMarker(body.header, "limit_texts", id++, Marker::TEXT_VIEW_FACING);
      text.pose.position = toPoint(calcTextPlace(centre, toVec3(body.cable_points[first]), extent));
      text.scale.z = kTextHeight * extent;
      text.color = toRgba(kLimitColour);
      text.text = describe(limit);
      text.lifetime = ros::Duration(0.2);
      markers.markers.push_back(std::move(text));
    }
  }
  heads.lifetime = ros::Duration(0.2);
  if (!heads.points.empty()) markers.markers.push_back(std::move(heads));
}

void Trail::add(ros::Time stamp, const Vec3& point) {
  if (!samples_.empty() && stamp < samples_.back().stamp) samples_.clear();
  samples_.push_back({stamp, point});
  while ((stamp - samples_.front().stamp).toSec() > duration_) samples_.pop_front();
}

void Trail::draw(const std_msgs::Header& header, const std::string& name, int id, double width,
                 MarkerArray& markers) const {
  if (samples_.size() < 2) return;
  Marker marker = makeMarker(header, name, id, Marker::LINE_STRIP);
  marker.scale.x = width;
  for (const Sample& sample : samples_) {
    const double age = (samples_.back().stamp - sample.stamp).toSec() / duration_;
    Colour colour = colour_;
    colour[3] *= 1 - 0.9 * age;
    addVertex(sample.point, colour, marker);
  }
  markers.markers.push_back(std::move(marker));
}

}  // namespace sinew
