#pragma once

namespace sinew {

/// Lame's parameters of an isotropic linear elastic law.
struct Lame {
  double lambda = 0;  ///< Pa
  double mu = 0;      ///< Pa
};

/// From Young's modulus [Pa] and Poisson's ratio (-1, 0.5).
constexpr Lame calcLame(double young_modulus, double poisson_ratio) {
  return {young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio)),
          young_modulus / (2 * (1 + poisson_ratio))};
}

}  // namespace sinew
