#include "sinew/mesh/tet_mesh.h"

namespace sinew {

double tetVolume(const TetMesh& mesh, int t) {
  const std::array<int, 4>& tet = mesh.tets[static_cast<std::size_t>(t)];
  const auto node = [&](int corner) -> const Vec3& {
    return mesh.nodes[static_cast<std::size_t>(tet[static_cast<std::size_t>(corner)])];
  };
  const Vec3& origin = node(0);
  return (node(1) - origin).cross(node(2) - origin).dot(node(3) - origin) / 6;
}

}  // namespace sinew
