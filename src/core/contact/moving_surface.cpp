#include "sinew/contact/moving_surface.h"

#include <algorithm>
#include <cmath>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kTie = 1e-6;  // part of a triangle by which a point may miss it

/// acos to 7e-5, Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.45.
double calcAngle(double cosine) {
  const double x = std::min(1.0, std::abs(cosine));
  const double angle = std::sqrt(1 - x) * (1.5707288 + x * (-0.2121144 + x * (0.0742610 - x * 0.0187293)));
  return cosine < 0 ? M_PI - angle : angle;
}

std::vector<Vec3> selectNodes(const CollisionSurface& topology, const std::vector<Vec3>& nodes) {
  std::vector<Vec3> selected;
  for (int v = 0; v < topology.vertices(); ++v) {
    if (topology.node(v) < 0 || topology.node(v) >= static_cast<int>(nodes.size())) {
      throw ConfigError("collision surface", "node " + std::to_string(topology.node(v)),
                        "one of the " + std::to_string(nodes.size()) + " nodes");
    }
    selected.push_back(nodes[topology.node(v)]);
  }
  return selected;
}

}  // namespace

MovingSurface::MovingSurface(const CollisionSurface& topology, const std::vector<Vec3>& rest)
    : topology_(topology),
      rest_(selectNodes(topology, rest)),
      positions_(rest_),
      face_normals_(topology.triangles().size()),
      edge_normals_(topology.edges().size()),
      vertex_normals_(rest_.size()),
      face_areas_(topology.triangles().size()),
      vertex_areas_(rest_.size()),
      bends_(topology.edges().size()),
      directions_(topology.triangles().size()),
      tree_(topology.triangles(), rest_) {
  updateNormals();
}

void MovingSurface::update(const std::vector<Vec3>& nodes) {
  for (int v = 0; v < topology_.vertices(); ++v) positions_[v] = nodes[topology_.node(v)];
  tree_.refit(topology_.triangles(), positions_);
  updateNormals();
}

void MovingSurface::updateRigid(const Pose& pose) {
  for (int v = 0; v < topology_.vertices(); ++v) positions_[v] = pose * rest_[v];
  tree_.refit(topology_.triangles(), positions_);
  updateNormals();
}

void MovingSurface::updateNormals() {
  std::fill(vertex_normals_.begin(), vertex_normals_.end(), Vec3::Zero());
  std::fill(vertex_areas_.begin(), vertex_areas_.end(), 0.0);
  for (int t = 0; t < static_cast<int>(face_normals_.size()); ++t) {
    const CollisionSurface::Triangle& corners = topology_.triangles()[t];
    Vec3 sides[3];
    double inverse[3];  // of their lengths, 1/m
    for (int i = 0; i < 3; ++i) {
      sides[i] = corner(t, (i + 1) % 3) - corner(t, i);
      inverse[i] = 1 / sides[i].norm();
    }
    const Vec3 doubled = sides[2].cross(sides[0]);
    const double norm = doubled.norm();
    face_areas_[t] = norm / 2;
    face_normals_[t] = norm > 0 ? Vec3(doubled / norm) : Vec3(Vec3::Zero());
    for (int i = 0; i < 3; ++i) {
      const int before = (i + 2) % 3;
      const double cosine = -sides[i].dot(sides[before]) * inverse[i] * inverse[before];
      vertex_normals_[corners[i]] += calcAngle(cosine) * face_normals_[t];
      vertex_areas_[corners[i]] += norm / 6;
    }
  }
  updateEdges();
  updateDirections();
}

void MovingSurface::updateEdges() {
  for (int e = 0; e < static_cast<int>(edge_normals_.size()); ++e) {
    const auto& faces = topology_.edges()[e].triangles;
    edge_normals_[e] = face_normals_[faces[0]] + face_normals_[faces[1]];
    bends_[e] = -face_normals_[faces[0]].dot(calcInward(e, 1));
  }
}

void MovingSurface::updateDirections() {
  std::fill(directions_.begin(), directions_.end(), Box());
  for (int t = 0; t < static_cast<int>(face_normals_.size()); ++t) {
    directions_[t].extend(face_normals_[t]);
    for (const int edge : topology_.edgesOf(t)) directions_[t].extend(edge_normals_[edge] / 2);
    for (const int vertex : topology_.triangles()[t]) directions_[t].extend(vertex_normals_[vertex] / (2 * M_PI));
  }
  tree_.refitNormals(directions_);
}

double MovingSurface::edgeArea(int edge) const {
  const auto& faces = topology_.edges()[edge].triangles;
  return (face_areas_[faces[0]] + face_areas_[faces[1]]) / 3;
}

Vec3 MovingSurface::calcInward(int edge, int i) const {
  const CollisionSurface::Edge& here = topology_.edges()[edge];
  const Vec3 along = positions_[here.vertices[1]] - positions_[here.vertices[0]];
  const Vec3 inward = face_normals_[here.triangles[i]].cross(i == 0 ? along : Vec3(-along));
  return inward.normalized();
}

bool MovingSurface::projectsInto(int triangle, const Vec3& p, Vec3* weights) const {
  const Vec3& origin = corner(triangle, 0);
  const Vec3 u = corner(triangle, 1) - origin;
  const Vec3 v = corner(triangle, 2) - origin;
  const Vec3& normal = face_normals_[triangle];
  const double doubled = 2 * face_areas_[triangle];
  const double wu = normal.dot((p - origin).cross(v)) / doubled;
  const double wv = normal.dot(u.cross(p - origin)) / doubled;
  if (!(wu >= -kTie && wv >= -kTie && wu + wv <= 1 + kTie)) return false;
  *weights = Vec3(1 - wu - wv, wu, wv);
  return true;
}

double MovingSurface::calcVertexSlope(int vertex, const Vec3& d) const {
  double least = 1;
  for (const int neighbour : topology_.neighboursOf(vertex)) {
    const Vec3 edge = positions_[neighbour] - positions_[vertex];
    least = std::min(least, d.dot(edge) / edge.norm());
  }
  return least;
}

double MovingSurface::calcEdgeSlope(int edge, const Vec3& d) const {
  return std::min(d.dot(calcInward(edge, 0)), d.dot(calcInward(edge, 1)));
}

}  // namespace sinew
