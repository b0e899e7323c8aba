#pragma once

namespace sinew {

/// How the stiffness matrix is factorised.
enum class CholeskyMethod {
  kSupernodal,  ///< Sinew's own
  kCholmod      ///< SuiteSparse's: reference and fall-back; not in every build
};

}  // namespace sinew
