#pragma once

#include <array>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/fem/corotational_tet.h"
#include "sinew/linalg/block_matrix.h"
#include "sinew/mesh/tet_mesh.h"

namespace sinew {

struct Material {
  Lame lame;
  double density = 0;  ///< kg/m3
};

/// The discretised body: everything that does not change while it moves. Fixed nodes are no unknowns; the others are
/// numbered in mesh order, three degrees of freedom each.
class FemModel {
 public:
  struct Element {
    std::array<int, 4> nodes;         ///< mesh nodes, ascending, so that block (a, b) with a > b is a lower one
    std::array<BlockSlot, 10> slots;  ///< of the stiffness blocks; first = -1 where a node is fixed
    TetShape shape;
    Lame lame;
  };

  /// `material` gives one per tetrahedron; `couplings` lists mesh nodes that something else than an element couples
  /// (a cable between two of its via points).
  FemModel(const TetMesh& mesh, const std::vector<Material>& material, const std::vector<bool>& fixed,
           const std::vector<std::vector<int>>& couplings);

  const std::vector<Vec3>& rest() const { return rest_; }
  const std::vector<Element>& elements() const { return elements_; }
  const BlockPattern& pattern() const { return pattern_; }
  int nodeCount() const { return static_cast<int>(rest_.size()); }
  int freeCount() const { return pattern_.blocks(); }
  int size() const { return pattern_.size(); }                 ///< degrees of freedom
  int freeIndex(int node) const { return free_index_[node]; }  ///< -1 for a fixed node
  const std::vector<int>& freeNodes() const { return free_nodes_; }
  const VecX& mass() const { return mass_; }  ///< lumped, kg, one per free node

 private:
  std::vector<Vec3> rest_;
  std::vector<int> free_index_;
  std::vector<int> free_nodes_;
  BlockPattern pattern_;
  std::vector<Element> elements_;
  VecX mass_;
};

/// What one assembly writes, over and over.
struct FemData {
  explicit FemData(const FemModel& model);
  VecX force;                   ///< elastic nodal forces on the free nodes, N
  BlockMatrix tangent;          ///< -d force / d position, N/m
  std::vector<Mat3> rotations;  ///< of the elements, the next assembly's guess
};

/// Elastic forces at `positions` [m, every mesh node], and the tangent stiffness.
void assemble(const FemModel& model, const std::vector<Vec3>& positions, Tangent tangent, FemData& data);
/// The forces alone.
void assembleForces(const FemModel& model, const std::vector<Vec3>& positions, FemData& data);

}  // namespace sinew
