#include "sinew/mesh/stl_reader.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "common/complaint.h"
#include "robot/temporary_folder.h"

namespace sinew {
namespace {

using Triangle = std::array<Vec3, 3>;

/// A unit tetrahedron, normals outwards.
const std::vector<Triangle> kTetrahedron = {
    Triangle{{Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(1, 0, 0)}}, Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)}},
    Triangle{{Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(0, 1, 0)}}, Triangle{{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}}};

std::string writeText(const std::vector<Triangle>& triangles) {
  std::string text = "solid with a name\n";
  for (const Triangle& triangle : triangles) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const Vec3& corner : triangle) {
      text += "   vertex " + std::to_string(corner.x()) + " " + std::to_string(corner.y()) + " " +
              std::to_string(corner.z()) + "\n";
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid with a name\n";
}

std::string writeBinary(const std::vector<Triangle>& triangles, const std::string& header) {
  std::string bytes = header;
  bytes.resize(80, ' ');
  const auto append = [&bytes](const auto& value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  };
  append(static_cast<std::uint32_t>(triangles.size()));
  for (const Triangle& triangle : triangles) {
    for (int axis = 0; axis < 3; ++axis) append(0.0F);
    for (const Vec3& corner : triangle) {
      for (int axis = 0; axis < 3; ++axis) append(static_cast<float>(corner[axis]));
    }
    append(std::uint16_t{0});
  }
  return bytes;
}

class StlReader : public testing::Test {
 protected:
  TemporaryFolder folder;

  void expectTetrahedron(const std::string& bytes) const {
    const StlMesh mesh = readStl(folder.write("body.stl", bytes));
    ASSERT_EQ(mesh.vertices.size(), 4U) << "corners are shared";
    ASSERT_EQ(mesh.triangles.size(), 4U);
    double volume = 0;
    for (const std::array<int, 3>& t : mesh.triangles) {
      volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
    }
    EXPECT_NEAR(volume, 1.0 / 6, 1e-12);
  }

  std::string complain(const std::string& bytes) const {
    return complaintOf([&] { readStl(folder.write("body.stl", bytes)); });
  }
};

TEST_F(StlReader, ReadsText) {
  expectTetrahedron(writeText(kTetrahedron));
}

TEST_F(StlReader, ReadsBinary) {
  expectTetrahedron(writeBinary(kTetrahedron, "made by something"));
}

TEST_F(StlReader, ReadsBinaryThatBeginsLikeText) {
  expectTetrahedron(writeBinary(kTetrahedron, "solid made by something else"));
}

TEST_F(StlReader, PassesOverTrianglesWithoutArea) {
  std::vector<Triangle> triangles = kTetrahedron;
  triangles.push_back({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, 0)}});
  expectTetrahedron(writeText(triangles));
}

TEST_F(StlReader, NamesWhatIsWrong) {
  const std::string text = writeText(kTetrahedron);
  EXPECT_NE(complain(text.substr(0, text.size() / 2)).find("body.stl"), std::string::npos);
  EXPECT_NE(complain("solid nothing\nendsolid\n").find("found no triangle"), std::string::npos);
  EXPECT_NE(complain("solid x\n facet normal 0 0 up").find("up"), std::string::npos);
  const std::string bytes = writeBinary(kTetrahedron, "x");
  EXPECT_NE(complain(bytes.substr(0, bytes.size() - 7)).find("body.stl"), std::string::npos);
  EXPECT_NE(complaintOf([&] { readStl(folder.path() + "/none.stl"); }).find("none.stl"), std::string::npos);
}

}  // namespace
}  // namespace sinew
