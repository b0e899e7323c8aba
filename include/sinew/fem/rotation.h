#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Updates `R` to the proper rotation (det = +1) that maximises tr(R^T F): the rotation of the polar decomposition
/// where det F > 0, and for flat or inverted F the nearest proper one. `R` enters as a guess, best from the last cycle.
/// Newton on the sphere of rotations: with S = R^T F, the turn w solves (tr(S) I - sym S) w = axial(S - S^T) and
/// R <- R exp(w); falls back on the singular value decomposition where that does not converge.
void updateRotation(const Mat3& F, Mat3& R);

}  // namespace sinew
