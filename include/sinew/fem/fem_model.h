#pragma once

#include <array>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/fem/corotational_tet.h"
#include "sinew/fem/tet_kernels.h"
#include "sinew/linalg/factor_pattern.h"
#include "sinew/mesh/tet_mesh.h"

namespace sinew {

struct Material {
  Lame lame;
  double density = 0;  ///< kg/m3
};

/// The discretised body: everything that does not change while it moves. Fixed nodes are no unknowns; the others are
/// numbered in the order in which the factorisation eliminates them, three degrees of freedom each.
class FemModel {
 public:
  struct Element {
    std::array<int, 4> nodes;         ///< mesh nodes by ascending free index: block (a, b) with a > b is a lower one
    std::array<BlockSlot, 10> slots;  ///< of the stiffness blocks; first = -1 where a node is fixed
    TetShape shape;
    Lame lame;
  };

  /// `material` gives one per tetrahedron; `couplings` lists mesh nodes that something else than an element couples
  /// (a cable between two of its via points). The order of elimination is the best for `threads`.
  FemModel(const TetMesh& mesh, const std::vector<Material>& material, const std::vector<bool>& fixed,
           const std::vector<std::vector<int>>& couplings, int threads = 1);

  const std::vector<Vec3>& rest() const { return rest_; }
  const std::vector<Element>& elements() const { return elements_; }
  const std::vector<TetBatch>& batches() const { return batches_; }  ///< the same for the kernels
  const BlockPattern& pattern() const { return factor_.matrix(); }
  const FactorPattern& factor() const { return factor_; }  ///< of the tangent stiffness
  int nodeCount() const { return static_cast<int>(rest_.size()); }
  int freeCount() const { return pattern().blocks(); }
  int size() const { return pattern().size(); }                ///< degrees of freedom
  int freeIndex(int node) const { return free_index_[node]; }  ///< -1 for a fixed node
  const std::vector<int>& freeNodes() const { return free_nodes_; }
  const VecX& mass() const { return mass_; }  ///< lumped, kg, one per free node

 private:
  struct Numbering {
    std::vector<int> free_index;
    FactorPattern factor;
  };
  static Numbering makeNumbering(const TetMesh& mesh, const std::vector<bool>& fixed,
                                 const std::vector<std::vector<int>>& couplings, int threads);
  FemModel(const TetMesh& mesh, const std::vector<Material>& material, Numbering numbering);

  std::vector<Vec3> rest_;
  std::vector<int> free_index_;
  std::vector<int> free_nodes_;
  FactorPattern factor_;
  std::vector<Element> elements_;
  std::vector<TetBatch> batches_;
  VecX mass_;
};

/// What one assembly writes, over and over.
struct FemData {
  explicit FemData(const FemModel& model, InstructionSet set = chooseInstructionSet());
  VecX force;                            ///< elastic nodal forces on the free nodes, N
  BlockMatrix tangent;                   ///< -d force / d position, N/m
  std::vector<RotationBatch> rotations;  ///< of the model's batches, the next assembly's guess
  Eigen::Matrix4Xd kernel_forces;        ///< what the kernels add to: a column per free node, its last entry idle
  TetKernels kernels;
};

/// Elastic forces at `positions` [m, every mesh node], and the tangent stiffness.
void assemble(const FemModel& model, const std::vector<Vec3>& positions, Tangent tangent, FemData& data);
/// The forces alone.
void assembleForces(const FemModel& model, const std::vector<Vec3>& positions, FemData& data);

}  // namespace sinew
