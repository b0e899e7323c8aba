#include "sinew/mesh/read_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "mesh/bar_mesh.h"
#include "mesh/largest_allocation.h"
#include "mesh/mesh_files.h"
#include "sinew/mesh/embedding.h"
#include "sinew/mesh/quality.h"

namespace sinew {
namespace {

const Vec3 kSize(30, 20, 10);

TetMesh makeTaggedBar() {
  TetMesh mesh = makeBarMesh(kSize, 2, 1, 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.region[t] = t < 5 ? 1 : 2;
  return mesh;
}

struct NamedFile {
  std::string name;
  std::string bytes;
};

std::vector<NamedFile> makeFilesOfEveryKind() {
  const TetMesh mesh = makeTaggedBar();
  std::vector<NamedFile> files;
  for (const double version : {2.0, 5.1}) {
    for (const bool binary : {false, true}) {
      VtkOptions options;
      options.version = version;
      options.binary = binary;
      options.region = VtkOptions::Region::kField;
      files.push_back({"mesh.vtk", makeVtkFile(mesh, options)});
    }
  }
  for (const auto numbers : {FileBuilder::Numbers::kText, FileBuilder::Numbers::kLittleEndian}) {
    files.push_back({"mesh.msh", makeGmshFile(mesh, {numbers, "\n"})});
  }
  return files;
}

class ReadMeshTest : public testing::Test {
 protected:
  /// Reads a damaged file: a mesh, or a ConfigError that names the file; never an allocation out of proportion.
  void readDamaged(const std::string& name, const std::string& bytes) {
    const std::string path = folder_.write(name, bytes);
    resetLargestAllocation();
    try {
      const TetMesh mesh = readMesh(path, 1e-3);
      for (const std::array<int, 4>& tet : mesh.tets) {
        for (const int node : tet) ASSERT_TRUE(node >= 0 && static_cast<std::size_t>(node) < mesh.nodes.size());
      }
      checkMesh(mesh);
      ++meshes_;
    } catch (const ConfigError& error) {
      ASSERT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      ++errors_;
    }
    ASSERT_LT(largestAllocation(), 100 * bytes.size() + 100000);
  }

  TempFolder folder_;
  int meshes_ = 0;
  int errors_ = 0;
};

TEST_F(ReadMeshTest, ScalesToMetres) {
  for (const NamedFile& file : makeFilesOfEveryKind()) {
    const TetMesh mesh = readMesh(folder_.write(file.name, file.bytes), 1e-3);
    const MeshReport report = checkMesh(mesh);
    EXPECT_TRUE(report.errors.empty());
    EXPECT_NEAR(report.volume, 1e-9 * kSize.prod(), 1e-18);
    EXPECT_TRUE(report.upper.isApprox(1e-3 * kSize));
    EXPECT_EQ(mesh.region, makeTaggedBar().region);
  }
}

TEST_F(ReadMeshTest, TurnsInvertedTetrahedra) {
  TetMesh mesh = makeTaggedBar();
  std::swap(mesh.tets[3][0], mesh.tets[3][1]);
  const TetMesh found = readMesh(folder_.write("mesh.vtk", makeVtkFile(mesh, {})), 1);
  for (int t = 0; t < static_cast<int>(found.tets.size()); ++t) EXPECT_GT(tetVolume(found, t), 0);
}

TEST_F(ReadMeshTest, KeepsUnusedNodesSoThatNumbersStay) {
  TetMesh mesh = makeTaggedBar();
  mesh.nodes.insert(mesh.nodes.begin(), Vec3(1, 2, 3));
  for (std::array<int, 4>& tet : mesh.tets) {
    for (int& node : tet) ++node;
  }
  const TetMesh found = readMesh(folder_.write("mesh.vtk", makeVtkFile(mesh, {})), 1);
  EXPECT_EQ(found.nodes, mesh.nodes);
  EXPECT_EQ(found.tets, mesh.tets);
}

TEST_F(ReadMeshTest, ReadsTheUpperCaseExtension) {
  EXPECT_NO_THROW(readMesh(folder_.write("MESH.VTK", makeVtkFile(makeTaggedBar(), {})), 1));
}

TEST_F(ReadMeshTest, NamesWhatIsWrong) {
  const std::string good = folder_.write("mesh.vtk", makeVtkFile(makeTaggedBar(), {}));
  expectConfigError([&] { readMesh(good, 0); }, {"scale", "mesh.vtk", "0.001"});
  expectConfigError([&] { readMesh(good, -1); }, {"scale"});
  expectConfigError([&] { readMesh(good, std::nan("")); }, {"scale"});
  expectConfigError([&] { readMesh(folder_.path("none.vtk"), 1); }, {"none.vtk", "no such file"});
  expectConfigError([&] { readMesh(folder_.write("mesh.stl", "solid"), 1); },
                    {"'.stl'", ".vtk", ".msh", "convert_mesh"});
  expectConfigError([&] { readMesh(folder_.write("empty.msh", ""), 1); }, {"empty.msh", "$MeshFormat"});
}

TEST_F(ReadMeshTest, RefusesAMeshWithoutTetrahedra) {
  TetMesh mesh = makeTaggedBar();
  mesh.tets.clear();
  mesh.region.clear();
  const std::string path = folder_.write("mesh.vtk", makeVtkFile(mesh, {}));
  expectConfigError([&] { readMesh(path, 1); }, {"mesh.vtk", "no tetrahedra", "convert_mesh"});
}

TEST_F(ReadMeshTest, RefusesCoordinatesThatAreNotFinite) {
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), 1e308}) {
    TetMesh mesh = makeTaggedBar();
    mesh.nodes[7].z() = wrong;
    VtkOptions options;
    options.binary = true;
    const std::string path = folder_.write("mesh.vtk", makeVtkFile(mesh, options));
    expectConfigError([&] { readMesh(path, 1e3); }, {"mesh.vtk, node 7", "not a number"});
  }
}

TEST_F(ReadMeshTest, SurvivesTruncation) {
  constexpr std::size_t kStep = 7;  // bytes: numbers of 2, 4 and 8 bytes are cut at each of their bytes
  for (const NamedFile& file : makeFilesOfEveryKind()) {
    for (std::size_t length = 0; length < file.bytes.size(); length += kStep) {
      readDamaged(file.name, file.bytes.substr(0, length));
    }
  }
  EXPECT_GT(errors_, 10 * meshes_);
}

TEST_F(ReadMeshTest, SurvivesDamagedBytes) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> byte(0, 255);
  for (const NamedFile& file : makeFilesOfEveryKind()) {
    std::uniform_int_distribution<std::size_t> place(0, file.bytes.size() - 1);
    for (int trial = 0; trial < 600; ++trial) {
      std::string bytes = file.bytes;
      for (int damages = 1 + trial % 3; damages > 0; --damages) bytes[place(random)] = static_cast<char>(byte(random));
      readDamaged(file.name, bytes);
    }
  }
  EXPECT_GT(errors_, 300);
  EXPECT_GT(meshes_, 300);
}

TEST_F(ReadMeshTest, SurvivesHugeNumbersInEveryPlace) {
  const std::string huge = "999999999";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  for (const NamedFile& file : makeFilesOfEveryKind()) {
    for (std::size_t at = 0; at < file.bytes.size();) {
      std::size_t end = at;
      while (end < file.bytes.size() && is_digit(file.bytes[end])) ++end;
      if (end > at) readDamaged(file.name, std::string(file.bytes).replace(at, end - at, huge));
      at = end + 1;
    }
  }
  EXPECT_GT(errors_, 300);
}

TEST_F(ReadMeshTest, SurvivesHugeBinaryNumbersInEveryPlace) {
  const std::string little("\xff\xff\xff\x3f\0\0\0\0", 8);
  const std::string big(little.rbegin(), little.rend());
  for (const NamedFile& file : makeFilesOfEveryKind()) {
    for (std::size_t at = 0; at + 8 <= file.bytes.size(); at += 4) {
      readDamaged(file.name, std::string(file.bytes).replace(at, 8, file.name == "mesh.msh" ? little : big));
    }
  }
  EXPECT_GT(errors_, 300);
}

/// Points just outside a mesh of mixed cells are carried by it, and it is known how far outside they are.
TEST_F(ReadMeshTest, EmbedsPointsJustOutside) {
  VtkOptions options;
  options.binary = true;
  const TetMesh mesh = readMesh(folder_.write("mesh.vtk", makeVtkFile(makeTaggedBar(), options)), 1e-3);
  const PointLocator locator(mesh);
  EXPECT_EQ(locator.locate(Vec3(0.011, 0.007, 0.004)).distance, 0);
  EXPECT_NEAR(locator.locate(Vec3(0.011, 0.007, 0.0105)).distance, 0.5e-3, 1e-15);
  EXPECT_NEAR(locator.locate(Vec3(0.033, 0.024, 0.004)).distance, 5e-3, 1e-15);
}

class ShippedMesh : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(ShippedMesh, IsGoodAndStandsOnItsBase) {
  const auto [name, length] = GetParam();
  const TetMesh mesh = readMesh(std::string(SINEW_SOURCE_DIR) + "/config/" + name, 1);
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.errors.empty()) << report.errors.front();
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
  EXPECT_EQ(report.pieces, 1);
  EXPECT_GT(report.worst_quality, 0.4);
  EXPECT_NEAR(report.lower.z(), 0, 1e-12);
  EXPECT_NEAR(report.upper.z(), length, 1e-12);
  const auto is_free = [](const Vec3& node) { return node.z() > 1e-6; };
  EXPECT_GE(std::count_if(mesh.nodes.begin(), mesh.nodes.end(), is_free), 500);
  EXPECT_LE(mesh.nodes.size(), 640u);
}

INSTANTIATE_TEST_SUITE_P(Robots, ShippedMesh,
                         testing::Values(std::make_pair("trunk/trunk.vtk", 0.2),
                                         std::make_pair("accordion/accordion.msh", 0.06)));

}  // namespace
}  // namespace sinew
