#pragma once

#include "sinew/fem/tet_batch.h"
#include "sinew/linalg/instruction_set.h"

namespace sinew {

/// Where an assembly reads and what it adds to.
struct TetAssembly {
  const double* positions;  ///< m, three for every mesh node
  double* forces;           ///< N, four for every free node: x y z and an idle one
  double* tangent;          ///< N/m, values of the block matrix
  bool exact;               ///< or semi-definite
};

/// The inner loop of the assembly, compiled once per instruction set. It adds what the elements of a batch contribute
/// and updates their rotations. Elements that are not for it (the rotation is too far from the last one or nearly
/// undetermined, the turning stiffness is too large or, where a semi-definite tangent is asked for, has a negative
/// part) contribute nothing and are returned, lane i at bit i.
using TetKernel = unsigned (*)(const TetBatch& batch, RotationBatch& rotations, const TetAssembly& assembly);

struct TetKernels {
  TetKernel linearise;  ///< forces and tangent
  TetKernel forces;
};

TetKernels tetKernelsOf(InstructionSet set);

}  // namespace sinew
