#include "sinew/mesh/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "mesh/bar_mesh.h"

namespace sinew {
namespace {

const Vec3 kSize(0.1, 0.02, 0.03);

bool hasMessage(const std::vector<std::string>& messages, const std::string& words) {
  for (const std::string& message : messages) {
    if (message.find(words) != std::string::npos) return true;
  }
  return false;
}

std::string join(const std::vector<std::string>& messages) {
  std::string all;
  for (const std::string& message : messages) all += "\n  " + message;
  return all;
}

#define EXPECT_MESSAGE(messages, words) \
  EXPECT_TRUE(hasMessage(messages, words)) << "'" words "' not in:" << join(messages)

TetMesh makeSingleTet(const Vec3& top) {
  TetMesh mesh;
  mesh.nodes = {Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0), top};
  mesh.tets = {{0, 1, 2, 3}};
  mesh.region = {0};
  return mesh;
}

/// Adds a copy of the tetrahedra of `mesh` that uses `node(i)` in place of node i.
template <typename Map>
void appendTets(TetMesh& mesh, const TetMesh& other, Map node) {
  for (std::array<int, 4> tet : other.tets) {
    for (int& corner : tet) corner = node(corner);
    mesh.tets.push_back(tet);
    mesh.region.push_back(0);
  }
}

TEST(Quality, OfAGoodMeshIsReportedWithoutComplaint) {
  const MeshReport report = checkMesh(makeBarMesh(kSize, 5, 2, 3));
  EXPECT_TRUE(report.errors.empty()) << join(report.errors);
  EXPECT_TRUE(report.warnings.empty()) << join(report.warnings);
  EXPECT_EQ(report.tets, 6 * 30);
  EXPECT_EQ(report.nodes, 6 * 3 * 4);
  EXPECT_EQ(report.pieces, 1);
  EXPECT_NEAR(report.volume, kSize.prod(), 1e-15);
  EXPECT_TRUE(report.lower.isApprox(Vec3::Zero()));
  EXPECT_TRUE(report.upper.isApprox(kSize));
}

TEST(Quality, IsOneForARegularTetrahedronAndZeroForAFlatOne) {
  TetMesh mesh;
  mesh.nodes = {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1), Vec3(1, -1, 3)};
  mesh.tets = {{0, 1, 3, 2}, {0, 2, 3, 1}};
  mesh.region = {0, 0};
  const int regular = tetVolume(mesh, 0) > 0 ? 0 : 1;
  EXPECT_NEAR(calcTetQuality(mesh, regular), 1, 1e-14);
  EXPECT_EQ(calcTetQuality(mesh, 1 - regular), 0) << "inverted";
  mesh.nodes[3] = (mesh.nodes[0] + mesh.nodes[1] + mesh.nodes[2]) / 3;
  EXPECT_NEAR(calcTetQuality(mesh, regular), 0, 1e-10);
}

TEST(Quality, NamesInvertedTetrahedra) {
  TetMesh mesh = makeBarMesh(kSize, 2, 2, 2);
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  std::swap(mesh.tets[9][0], mesh.tets[9][1]);
  EXPECT_MESSAGE(checkMesh(mesh).errors, "2 inverted tetrahedra (negative volume), first: 7");
}

TEST(Quality, NamesFlatTetrahedra) {
  EXPECT_MESSAGE(checkMesh(makeSingleTet(Vec3(0.03, 0.03, 0))).errors, "1 flat tetrahedron (no volume), first: 0");
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.tets[3][1] = mesh.tets[3][0];
  EXPECT_MESSAGE(checkMesh(mesh).errors, "1 flat tetrahedron (no volume), first: 3");
}

TEST(Quality, NamesIndicesOutOfRange) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.tets[2][3] = 8;
  EXPECT_MESSAGE(checkMesh(mesh).errors, "1 tetrahedron with node indices out of range, first: 2; expected 0 to 7");
  mesh.tets[1][0] = -1;
  EXPECT_MESSAGE(checkMesh(mesh).errors, "2 tetrahedra with node indices out of range, first: 1");
}

TEST(Quality, NamesCoordinatesThatAreNotFinite) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.nodes[5].y() = std::nan("");
  EXPECT_MESSAGE(checkMesh(mesh).errors, "1 node with coordinates that are not finite, first: 5");
}

TEST(Quality, RefusesAMeshOfNothing) {
  EXPECT_MESSAGE(checkMesh(TetMesh()).errors, "no tetrahedra");
}

TEST(Quality, RefusesMissingRegionTags) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.region.pop_back();
  EXPECT_MESSAGE(checkMesh(mesh).errors, "5 region tags; expected one for each of the 6 tetrahedra");
}

TEST(Quality, NamesOverlappingTetrahedra) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.tets.push_back(mesh.tets[0]);
  mesh.region.push_back(0);
  EXPECT_MESSAGE(checkMesh(mesh).errors, "shared by more than two tetrahedra");
}

TEST(Quality, NamesUnusedNodes) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.nodes.push_back(Vec3(0.05, 0.01, 0.01));
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.errors.empty()) << join(report.errors);
  EXPECT_MESSAGE(report.warnings, "1 node used by no tetrahedron, first: 8");
}

TEST(Quality, CountsPieces) {
  const TetMesh bar = makeBarMesh(kSize, 2, 1, 1);
  TetMesh mesh = bar;
  const int shift = static_cast<int>(bar.nodes.size());
  for (const Vec3& node : bar.nodes) mesh.nodes.push_back(node + Vec3(0, 0.05, 0));
  appendTets(mesh, bar, [&](int i) { return i + shift; });
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.pieces, 2);
  EXPECT_MESSAGE(report.warnings, "in 2 pieces without common nodes, expected 1; if that is meant, set pieces: 2");
  ASSERT_EQ(report.piece.size(), mesh.nodes.size());
  for (int i = 0; i < static_cast<int>(mesh.nodes.size()); ++i) EXPECT_EQ(report.piece[i], i < shift ? 0 : 1);
  EXPECT_TRUE(checkMesh(mesh, 2).warnings.empty());
  EXPECT_MESSAGE(checkMesh(bar, 2).warnings, "in 1 piece without common nodes, expected 2");
}

TEST(Quality, NamesPartsThatHangByANode) {
  const TetMesh bar = makeBarMesh(kSize, 1, 1, 1);
  TetMesh mesh = bar;
  const int last = static_cast<int>(bar.nodes.size()) - 1;
  for (std::size_t i = 1; i < bar.nodes.size(); ++i) mesh.nodes.push_back(bar.nodes[i] + kSize);
  appendTets(mesh, bar, [&](int i) { return i + last; });
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.pieces, 1);
  EXPECT_MESSAGE(report.warnings, "hang together by a node or an edge only, without a common face: 2 parts in 1 piece");
}

TEST(Quality, NamesTheWorstSliver) {
  TetMesh mesh = makeSingleTet(Vec3(0.05, 0.05, 2e-3));
  mesh.nodes.push_back(Vec3(0.05, 0.05, -1e-3));
  mesh.tets.push_back({0, 2, 1, 4});
  mesh.region.push_back(0);
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.errors.empty()) << join(report.errors);
  EXPECT_MESSAGE(report.warnings, "2 slivers (quality below 0.2), worst: 1");
  EXPECT_NEAR(report.worst_quality, calcTetQuality(mesh, 1), 1e-15);
}

TEST(Quality, NamesDuplicatedNodes) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.nodes.push_back(mesh.nodes[mesh.tets[0].back()] + Vec3(0, 0, 1e-9));
  mesh.tets[0].back() = 8;
  EXPECT_MESSAGE(checkMesh(mesh).warnings, "1 node at the place of another");
}

TEST(Quality, RecognisesMillimetres) {
  EXPECT_MESSAGE(checkMesh(makeBarMesh(1e3 * kSize, 1, 1, 1)).warnings, "looks like mm; set scale: 0.001");
  EXPECT_MESSAGE(checkMesh(makeBarMesh(1e-3 * kSize, 1, 1, 1)).warnings, "looks too small");
}

}  // namespace
}  // namespace sinew
