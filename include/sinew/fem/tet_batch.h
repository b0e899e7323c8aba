#pragma once

namespace sinew {

/// What does not change of some tetrahedra, an array for every quantity, so that a processor computes on as many of
/// them at once as it can. Of n batches, number i holds the elements i, i + n, i + 2 n ...: neighbours, which add to
/// the same blocks, come a while after each other. Lanes without an element have no volume and are otherwise those of
/// another.
struct alignas(64) TetBatch {
  static constexpr int kSize = 16;
  double gradients[9][kSize];   ///< of the shape functions of nodes 1 2 3, x y z each, 1/m; 0's is minus their sum
  double volume[kSize];         ///< m3
  double lambda[kSize];         ///< Pa
  double mu[kSize];             ///< Pa
  unsigned position[4][kSize];  ///< of the nodes among the coordinates
  unsigned force[4][kSize];     ///< of the nodes among the forces
  unsigned first[10][kSize];    ///< of the stiffness blocks 00 10 11 20 21 22 30 31 32 33 among the matrix' values
  unsigned stride[10][kSize];   ///< between the columns of a block
  double free[4][kSize];        ///< 1, or 0 for a fixed node, whose force and blocks are those of any other then
  bool any_fixed;
};

/// Rotations of the elements of a batch: quaternions w x y z.
struct alignas(64) RotationBatch {
  double quaternion[4][TetBatch::kSize];
};

}  // namespace sinew
