#include "sinew/contact/smooth_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "check_line.h"
#include "contact/shapes.h"

namespace sinew {
namespace {

constexpr double kNarrow = 1e-6;   // of a slope: such pairs may be kept or not
constexpr double kShallow = 1e-8;  // m, of a dip below the ends of an edge or the border of a face

enum class Verdict { kNo, kEither, kYes };

Verdict both(Verdict a, Verdict b) {
  return std::min(a, b);
}

Verdict isAbove(double value, double threshold, double margin) {
  if (std::abs(value - threshold) < margin) return Verdict::kEither;
  return value > threshold ? Verdict::kYes : Verdict::kNo;
}

/// The minimum over [0, 1] of a convex function by ternary search.
template <typename Function>
double searchMinimum(const Function& function, int steps) {
  double left = 0, right = 1;
  for (int i = 0; i < steps; ++i) {
    const double a = left + (right - left) / 3, b = right - (right - left) / 3;
    (function(a) < function(b) ? right : left) = function(a) < function(b) ? b : a;
  }
  return (left + right) / 2;
}

/// The definition of ProximityDetection, feature by feature, from positions alone.
class Oracle {
 public:
  Oracle(const TriangleMesh& body, const ObstacleShape& shape, const Pose& pose, const ProximitySettings& settings)
      : body_(body), shape_(shape), pose_(pose), settings_(settings) {}

  struct Answer {
    Verdict verdict;
    double distance;
  };

  Answer judgeVertex(int vertex) const {
    const Vec3& x = body_.vertices[vertex];
    const Vec3 d = normalAt(x);
    Vec3 outward = Vec3::Zero();
    double slope = 1;
    for (std::size_t t = 0; t < body_.triangles.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        if (body_.triangles[t][i] != vertex) continue;
        const Vec3 a = (corner(t, i + 1) - x).normalized(), b = (corner(t, i + 2) - x).normalized();
        outward += std::acos(a.dot(b)) * normalOf(t);
        slope = std::min({slope, d.dot(a), d.dot(b)});
      }
    }
    return {judge(phi(x), slope, outward.normalized().dot(d)), phi(x)};
  }

  Answer judgeEdge(const CollisionSurface::Edge& edge) const {
    const Vec3 a = body_.vertices[edge.vertices[0]], b = body_.vertices[edge.vertices[1]];
    if (phi(a) - (b - a).norm() > settings_.alarm_distance) return {Verdict::kNo, phi(a)};
    const double t = searchMinimum([&](double at) { return phi(a + at * (b - a)); }, 80);
    const Vec3 x = a + t * (b - a);
    const Vec3 d = normalAt(x);
    double slope = 1;
    Vec3 outward = Vec3::Zero();
    for (int i = 0; i < 2; ++i) {
      const Vec3 across = body_.vertices[edge.opposite[i]] - a;
      const Vec3 along = (b - a).normalized();
      slope = std::min(slope, d.dot((across - along.dot(across) * along).normalized()));
      outward += normalOf(edge.triangles[i]);
    }
    if (phi(x) < 0) return {Verdict::kEither, phi(x)};  // inside, phi has kinks, and a kink has many normals
    const double dip = std::min(phi(a), phi(b)) - phi(x);
    return {both(isAbove(dip, kShallow, kShallow), judge(phi(x), slope, outward.normalized().dot(d))), phi(x)};
  }

  Answer judgeFace(int t) const {
    const Vec3 x0 = corner(t, 0), x1 = corner(t, 1), x2 = corner(t, 2);
    const double reach = std::max((x1 - x0).norm(), (x2 - x0).norm());
    if (phi(x0) - reach > settings_.alarm_distance) return {Verdict::kNo, phi(x0)};
    const auto at = [&](double u, double v) { return phi(x0 + v * (x2 - x0) + u * (1 - v) * (x1 - x0)); };
    const auto inner = [&](double v) { return searchMinimum([&](double u) { return at(u, v); }, 60); };
    const double v = searchMinimum([&](double w) { return at(inner(w), w); }, 60);
    const double u = inner(v);
    if (at(u, v) < 0) return {Verdict::kEither, at(u, v)};
    double border = 1e300;
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = corner(t, i), b = corner(t, i + 1);
      const double s = searchMinimum([&](double w) { return phi(a + w * (b - a)); }, 80);
      border = std::min(border, phi(a + s * (b - a)));
    }
    const Vec3 d = normalAt(x0 + v * (x2 - x0) + u * (1 - v) * (x1 - x0));
    return {both(isAbove(border - at(u, v), kShallow, kShallow), judge(at(u, v), 0, normalOf(t).dot(d))), at(u, v)};
  }

 private:
  Verdict judge(double distance, double slope, double facing) const {
    return both(both(isAbove(settings_.alarm_distance, distance, 1e-9), isAbove(slope, -settings_.slope, kNarrow)),
                isAbove(0, facing, 1e-3));
  }
  double phi(const Vec3& x) const { return shape_.calcDistance(pose_.inverse(Eigen::Isometry) * x).distance; }
  Vec3 normalAt(const Vec3& x) const {
    return pose_.linear() * shape_.calcDistance(pose_.inverse(Eigen::Isometry) * x).normal;
  }
  Vec3 corner(std::size_t t, int i) const { return body_.vertices[body_.triangles[t][i % 3]]; }
  Vec3 normalOf(std::size_t t) const {
    return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
  }

  const TriangleMesh& body_;
  const ObstacleShape& shape_;
  Pose pose_;
  ProximitySettings settings_;
};

struct Tally {
  int kept = 0, wrong = 0;
  double error = 0;

  void count(const Oracle::Answer& answer, std::uint64_t key, const std::map<std::uint64_t, double>& found) {
    const auto row = found.find(key);
    if (row != found.end()) {
      ++kept;
      error = std::max(error, std::abs(row->second - answer.distance));
    }
    const bool is_kept = row != found.end();
    if (answer.verdict != Verdict::kEither && is_kept != (answer.verdict == Verdict::kYes)) ++wrong;
  }
};

TEST(SmoothPairs, AreThoseOfTheDefinition) {
  Random random(10);
  const std::vector<TriangleMesh> bodies = {makeBall(0.02, 1), makeBar(Vec3(0.03, 0.02, 0.02), 2, 1, 1),
                                            makeFork(Vec3(0.03, 0.01, 0.03))};
  const std::vector<ObstacleShape> shapes = {ObstacleShape::makePlane(), ObstacleShape::makeSphere(0.01),
                                             ObstacleShape::makeCylinder(0.01, 0.03)};
  const ProximitySettings settings;
  Tally vertices, edges, faces;
  for (int scene = 0; scene < 300; ++scene) {
    TriangleMesh body = bodies[scene % 3];
    // Only the vertices in use, so that vertex and node are one.
    const CollisionSurface topology(body.triangles);
    TriangleMesh used;
    for (int v = 0; v < topology.vertices(); ++v) used.vertices.push_back(body.vertices[topology.node(v)]);
    used.triangles = topology.triangles();
    used.vertices = calcMoved(used.vertices, random.pose(0.02));
    for (Vec3& x : used.vertices) x += random.vector(1e-3);
    const ObstacleShape& shape = shapes[random.index(3)];
    const Pose pose = random.pose(0.02);

    const CollisionSurface surface(used.triangles);
    SmoothPairs pairs(settings, surface);
    ContactList list(300, 1800);
    list.begin();
    pairs.addPairs(MovingSurface(surface, used.vertices), shape, pose, 0, list);
    std::map<std::uint64_t, double> found;
    for (int i = 0; i < list.size(); ++i) found[list.row(i).key] = list.row(i).gap + settings.contact_distance;

    const Oracle oracle(used, shape, pose, settings);
    for (int v = 0; v < surface.vertices(); ++v) {
      vertices.count(oracle.judgeVertex(v), makeContactKey(0, PairKind::kVertexSmooth, v, 0), found);
    }
    for (int e = 0; e < static_cast<int>(surface.edges().size()); ++e) {
      edges.count(oracle.judgeEdge(surface.edges()[e]), makeContactKey(0, PairKind::kEdgeSmooth, e, 0), found);
    }
    for (int t = 0; t < static_cast<int>(used.triangles.size()); ++t) {
      faces.count(oracle.judgeFace(t), makeContactKey(0, PairKind::kFaceSmooth, t, 0), found);
    }
  }
  EXPECT_GT(vertices.kept, 150);
  EXPECT_GT(edges.kept, 100);
  EXPECT_GT(faces.kept, 50);
  checkFigure("detection_oracle.smooth_wrong", vertices.wrong + edges.wrong + faces.wrong, "<=", 0, "pairs");
  checkFigure("detection_oracle.smooth_distance", std::max({vertices.error, edges.error, faces.error}), "<=", 1e-9,
              "m");
}

TEST(SmoothPairs, OfACylinderOnEndUnderOneFaceHaveItsRim) {
  const TriangleMesh plate = makeBar(Vec3(0.1, 0.1, 0.01), 1, 1, 1);
  const ObstacleShape cylinder = ObstacleShape::makeCylinder(0.01, 0.04);
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(0.06, 0.03, -0.02 - 2e-3);
  const CollisionSurface surface(plate.triangles);
  const ProximitySettings settings;
  SmoothPairs pairs(settings, surface);
  ContactList list(300, 1800);
  list.begin();
  pairs.addPairs(MovingSurface(surface, plate.vertices), cylinder, pose, 0, list);
  list.finish();
  ASSERT_GE(list.size(), 8);
  Box around;
  for (int i = 0; i < list.size(); ++i) {
    EXPECT_NEAR(list.row(i).gap, 1e-3, 1e-12);
    EXPECT_LT((list.row(i).normal - Vec3::UnitZ()).norm(), 1e-9);
    around.extend(list.row(i).point);
  }
  EXPECT_GT((around.upper - around.lower).head<2>().minCoeff(), 0.019) << "a plate that tilts must find a row below it";
}

}  // namespace
}  // namespace sinew
