#include "sinew/mesh/quality.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <utility>

#include "sinew/mesh/surface.h"

namespace sinew {
namespace {

constexpr double kSliver = 0.2;       // quality
constexpr double kFlat = 1e-9;        // |volume| / (longest edge)^3
constexpr double kSameNode = 1e-6;    // distance / diagonal of the bounding box
constexpr double kLargeRobot = 5;     // m
constexpr double kSmallRobot = 1e-3;  // m

const Vec3& cornerOf(const TetMesh& mesh, int t, int corner) {
  return mesh.nodes[static_cast<std::size_t>(mesh.tets[static_cast<std::size_t>(t)][static_cast<std::size_t>(corner)])];
}

/// {longest, sum} of the six squared edge lengths.
std::pair<double, double> calcSquaredEdges(const TetMesh& mesh, int t) {
  double longest = 0;
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const double squared = (cornerOf(mesh, t, i) - cornerOf(mesh, t, j)).squaredNorm();
      longest = std::max(longest, squared);
      sum += squared;
    }
  }
  return {longest, sum};
}

bool isFlat(const TetMesh& mesh, int t) {
  const double longest = std::sqrt(calcSquaredEdges(mesh, t).first);
  return !(std::abs(tetVolume(mesh, t)) > kFlat * longest * longest * longest);
}

/// Disjoint sets of the integers 0 .. n - 1.
class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  int findRoot(int i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void unite(int i, int j) { at(findRoot(i)) = findRoot(j); }

 private:
  int& at(int i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<int> parent_;
};

/// Something found several times: how often, and one example.
struct Finding {
  int count = 0;
  int example = -1;
  void add(int index) {
    if (count++ == 0) example = index;
  }
};

std::string format(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

std::string plural(int count, const std::string& noun) {
  if (count == 1) return "1 " + noun;
  const std::string singular = "tetrahedron";
  const bool is_tet = noun.size() >= singular.size() && noun.substr(noun.size() - singular.size()) == singular;
  return std::to_string(count) + " " + (is_tet ? noun.substr(0, noun.size() - 2) + "a" : noun + "s");
}

bool hasValidIndices(const TetMesh& mesh, MeshReport& report) {
  Finding wrong;
  for (int t = 0; t < report.tets; ++t) {
    for (const int node : mesh.tets[static_cast<std::size_t>(t)]) {
      if (node < 0 || node >= report.nodes) {
        wrong.add(t);
        break;
      }
    }
  }
  if (wrong.count > 0) {
    report.errors.push_back(plural(wrong.count, "tetrahedron") + " with node indices out of range, first: " +
                            std::to_string(wrong.example) + "; expected 0 to " + std::to_string(report.nodes - 1));
  }
  return wrong.count == 0;
}

bool hasFiniteNodes(const TetMesh& mesh, MeshReport& report) {
  Finding wrong;
  for (int i = 0; i < report.nodes; ++i) {
    if (!mesh.nodes[static_cast<std::size_t>(i)].allFinite()) wrong.add(i);
  }
  if (wrong.count > 0) {
    report.errors.push_back(plural(wrong.count, "node") +
                            " with coordinates that are not finite, first: " + std::to_string(wrong.example));
  }
  return wrong.count == 0;
}

void checkShapes(const TetMesh& mesh, MeshReport& report) {
  Finding inverted, flat, slivers;
  report.worst_quality = std::numeric_limits<double>::infinity();
  for (int t = 0; t < report.tets; ++t) {
    const double volume = tetVolume(mesh, t);
    const double quality = calcTetQuality(mesh, t);
    report.volume += volume;
    if (isFlat(mesh, t)) {
      flat.add(t);
    } else if (volume < 0) {
      inverted.add(t);
    } else if (quality < kSliver) {
      slivers.add(t);
      if (quality < report.worst_quality) slivers.example = t;
    }
    report.worst_quality = std::min(report.worst_quality, quality);
  }
  if (inverted.count > 0) {
    report.errors.push_back(plural(inverted.count, "inverted tetrahedron") + " (negative volume), first: " +
                            std::to_string(inverted.example) + "; expected (n1 - n0) x (n2 - n0) . (n3 - n0) > 0");
  }
  if (flat.count > 0) {
    report.errors.push_back(plural(flat.count, "flat tetrahedron") +
                            " (no volume), first: " + std::to_string(flat.example) + "; remove them or mesh again");
  }
  if (slivers.count > 0) {
    report.warnings.push_back(plural(slivers.count, "sliver") + " (quality below " + format(kSliver) +
                              "), worst: " + std::to_string(slivers.example) + " with " +
                              format(calcTetQuality(mesh, slivers.example)) + "; a better mesh bends more truly");
  }
}

void checkUnusedNodes(const TetMesh& mesh, MeshReport& report) {
  std::vector<bool> is_used(mesh.nodes.size(), false);
  for (const std::array<int, 4>& tet : mesh.tets) {
    for (const int node : tet) is_used[static_cast<std::size_t>(node)] = true;
  }
  Finding unused;
  for (int i = 0; i < report.nodes; ++i) {
    if (!is_used[static_cast<std::size_t>(i)]) unused.add(i);
  }
  if (unused.count > 0) {
    report.warnings.push_back(plural(unused.count, "node") + " used by no tetrahedron, first: " +
                              std::to_string(unused.example) + "; they stay where they are");
  }
}

/// Sweeps along a direction that no regular mesh is aligned with, so that few nodes are compared.
void checkDuplicatedNodes(const TetMesh& mesh, MeshReport& report) {
  const double tolerance = kSameNode * (report.upper - report.lower).norm();
  const Vec3 direction = Vec3(1, std::sqrt(2.0), std::sqrt(3.0)).normalized();
  std::vector<std::pair<double, int>> order;
  order.reserve(mesh.nodes.size());
  for (int i = 0; i < report.nodes; ++i) order.emplace_back(direction.dot(mesh.nodes[static_cast<std::size_t>(i)]), i);
  std::sort(order.begin(), order.end());

  Finding duplicated;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Vec3& here = mesh.nodes[static_cast<std::size_t>(order[i].second)];
    for (std::size_t j = i + 1; j < order.size() && order[j].first - order[i].first <= tolerance; ++j) {
      if ((mesh.nodes[static_cast<std::size_t>(order[j].second)] - here).norm() > tolerance) continue;
      duplicated.add(order[i].second);
      break;
    }
  }
  if (duplicated.count > 0) {
    report.warnings.push_back(plural(duplicated.count, "node") +
                              " at the place of another, first: " + std::to_string(duplicated.example) +
                              "; the material is cut there unless they are merged");
  }
}

void findPieces(const TetMesh& mesh, int expected, MeshReport& report) {
  UnionFind sets(mesh.nodes.size());
  for (const std::array<int, 4>& tet : mesh.tets) {
    for (std::size_t i = 1; i < 4; ++i) sets.unite(tet[0], tet[i]);
  }
  report.piece.assign(mesh.nodes.size(), -1);
  std::vector<int> numbers(mesh.nodes.size(), -1);  // by root
  for (const std::array<int, 4>& tet : mesh.tets) {
    int& number = numbers[static_cast<std::size_t>(sets.findRoot(tet[0]))];
    if (number < 0) number = report.pieces++;
    for (const int node : tet) report.piece[static_cast<std::size_t>(node)] = number;
  }
  if (report.pieces != expected) {
    report.warnings.push_back("in " + plural(report.pieces, "piece") + " without common nodes, expected " +
                              std::to_string(expected) +
                              "; if that is meant, set pieces: " + std::to_string(report.pieces));
  }
}

void checkFaces(const TetMesh& mesh, MeshReport& report) {
  const std::vector<TetFace> faces = makeSortedFaces(mesh);
  UnionFind sets(mesh.tets.size());
  Finding crowded;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].corners != faces[i - 1].corners) continue;
    sets.unite(faces[i].tet, faces[i - 1].tet);
    if (i > 1 && faces[i].corners == faces[i - 2].corners) crowded.add(faces[i].tet);
  }
  int face_pieces = 0;
  for (int t = 0; t < report.tets; ++t) face_pieces += sets.findRoot(t) == t ? 1 : 0;
  if (crowded.count > 0) {
    report.errors.push_back(plural(crowded.count, "face") +
                            " shared by more than two tetrahedra, first at tetrahedron " +
                            std::to_string(crowded.example) + "; tetrahedra must not overlap");
  }
  if (face_pieces > report.pieces) {
    report.warnings.push_back(
        "parts that hang together by a node or an edge only, without a common face: " + std::to_string(face_pieces) +
        " parts in " + plural(report.pieces, "piece") + "; they turn about it freely");
  }
}

void checkSize(MeshReport& report) {
  const double size = (report.upper - report.lower).maxCoeff();
  if (size > kLargeRobot) {
    report.warnings.push_back("the mesh is " + format(size) + " m large: this looks like mm; set scale: 0.001");
  } else if (size < kSmallRobot) {
    report.warnings.push_back("the mesh is " + format(size) +
                              " m large: this looks too small; set scale: 1 if the file is in m");
  }
}

void calcBounds(const TetMesh& mesh, MeshReport& report) {
  Eigen::AlignedBox3d box;
  for (const Vec3& node : mesh.nodes) box.extend(node);
  report.lower = box.min();
  report.upper = box.max();
}

}  // namespace

double calcTetQuality(const TetMesh& mesh, int t) {
  const double volume = tetVolume(mesh, t);
  if (!(volume > 0)) return 0;
  return 12 * std::cbrt(9 * volume * volume) / calcSquaredEdges(mesh, t).second;
}

MeshReport checkMesh(const TetMesh& mesh, int expected_pieces) {
  MeshReport report;
  report.tets = static_cast<int>(mesh.tets.size());
  report.nodes = static_cast<int>(mesh.nodes.size());
  if (mesh.tets.empty()) report.errors.push_back("no tetrahedra; expected a volume mesh");
  if (mesh.region.size() != mesh.tets.size()) {
    report.errors.push_back(std::to_string(mesh.region.size()) + " region tags; expected one for each of the " +
                            plural(report.tets, "tetrahedron"));
  }
  if (mesh.tets.empty() || !hasValidIndices(mesh, report) || !hasFiniteNodes(mesh, report)) return report;

  calcBounds(mesh, report);
  checkShapes(mesh, report);
  findPieces(mesh, expected_pieces, report);
  checkFaces(mesh, report);
  checkUnusedNodes(mesh, report);
  checkDuplicatedNodes(mesh, report);
  checkSize(report);
  return report;
}

}  // namespace sinew
