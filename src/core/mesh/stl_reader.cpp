#include "sinew/mesh/stl_reader.h"

#include <filesystem>
#include <fstream>
#include <map>

#include "sinew/mesh/file_cursor.h"

namespace sinew {
namespace {

constexpr std::size_t kHeader = 80, kCount = 4, kTriangle = 50, kNormal = 12, kAttribute = 2;

/// A binary file is exactly as long as its count of triangles says; it may begin with "solid" as text does.
bool isBinary(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<unsigned char, kHeader + kCount> start{};
  if (!file.read(reinterpret_cast<char*>(start.data()), static_cast<std::streamsize>(start.size()))) return false;
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < kCount; ++i) triangles |= static_cast<std::size_t>(start[kHeader + i]) << (8 * i);
  return std::filesystem::file_size(path) == kHeader + kCount + kTriangle * triangles;
}

/// Gathers triangles by their corners.
class Builder {
 public:
  void add(const std::array<Vec3, 3>& corners) {
    std::array<int, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = findVertex(corners[i]);
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) return;
    mesh_.triangles.push_back(triangle);
  }

  StlMesh take() { return std::move(mesh_); }

 private:
  int findVertex(const Vec3& position) {
    const std::array<double, 3> key = {position.x(), position.y(), position.z()};
    const auto found = vertices_.emplace(key, static_cast<int>(mesh_.vertices.size()));
    if (found.second) mesh_.vertices.push_back(position);
    return found.first->second;
  }

  StlMesh mesh_;
  std::map<std::array<double, 3>, int> vertices_;
};

StlMesh readBinary(FileCursor& file) {
  const bool swap = !isLittleEndian();
  file.skipBytes(kHeader, "a header of 80 bytes");
  const auto triangles = file.readBinary<std::uint32_t>(swap, "the number of triangles");
  Builder builder;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    file.skipBytes(kNormal, "a normal");
    std::array<Vec3, 3> corners;
    for (Vec3& corner : corners) {
      for (int axis = 0; axis < 3; ++axis) {
        corner[axis] = static_cast<double>(file.readBinary<float>(swap, "a coordinate"));
      }
      if (!corner.allFinite()) file.fail("a coordinate that is not a number", "finite lengths");
    }
    file.skipBytes(kAttribute, "an attribute");
    builder.add(corners);
  }
  return builder.take();
}

StlMesh readText(FileCursor& file) {
  file.expectWord("solid");
  file.readLine();
  Builder builder;
  while (file.peekWord() != "endsolid") {
    file.expectWord("facet");
    file.expectWord("normal");
    for (int axis = 0; axis < 3; ++axis) file.readReal("a component of the normal");
    file.expectWord("outer");
    file.expectWord("loop");
    std::array<Vec3, 3> corners;
    for (Vec3& corner : corners) {
      file.expectWord("vertex");
      for (int axis = 0; axis < 3; ++axis) corner[axis] = file.readReal("a coordinate");
      if (!corner.allFinite()) file.fail("a coordinate that is not a number", "finite lengths");
    }
    file.expectWord("endloop");
    file.expectWord("endfacet");
    builder.add(corners);
  }
  return builder.take();
}

}  // namespace

StlMesh readStl(const std::string& path) {
  FileCursor file(path);
  StlMesh mesh = isBinary(path) ? readBinary(file) : readText(file);
  if (mesh.triangles.empty()) file.failFile("no triangle", "a triangle surface");
  return mesh;
}

}  // namespace sinew
