#pragma once

#include "sinew/fem/simd_rotation.h"
#include "sinew/fem/tet_batch.h"

namespace sinew {
namespace SINEW_ISA {

/// Co-rotational linear elasticity (the equations of corotational_tet.h) as a law for the kernel. A law keeps a `State`
/// of each element from one assembly to the next. In the present configuration it takes a shape function's gradient g
/// to push(g), on which it gives the traction P g, P the first Piola-Kirchhoff stress, and the block of two of them,
/// the derivative of P g_a by the node of g_b. Tractions and blocks are linear in each of what they are given.
class CorotationalLaw {
 public:
  using State = Quaternion;
  /// All that the blocks of one column take of q = R g.
  struct Prepared {
    Triple lambda;   ///< lambda q
    Triple mu;       ///< mu q
    Matrix turning;  ///< Q [q]x
  };

  static State loadState(const RotationBatch& rotations, int lane) {
    const auto& q = rotations.quaternion;
    return {Simd::load(q[0] + lane), {Simd::load(q[1] + lane), Simd::load(q[2] + lane), Simd::load(q[3] + lane)}};
  }

  static void storeState(const State& state, RotationBatch& rotations, int lane) {
    state.w.store(rotations.quaternion[0] + lane);
    state.v.x.store(rotations.quaternion[1] + lane);
    state.v.y.store(rotations.quaternion[2] + lane);
    state.v.z.store(rotations.quaternion[3] + lane);
  }

  /// Leaves `active` the elements that the law can treat.
  template <int kCount>
  static void updateStates(const Matrix (&F)[kCount], SimdMask (&active)[kCount], State (&states)[kCount]) {
    updateRotations(F, active, states);
  }

  CorotationalLaw(const TetBatch& batch, int lane, const Matrix& F, const State& state)
      : lambda_(Simd::load(batch.lambda + lane)),
        mu_(Simd::load(batch.mu + lane)),
        R_(calcMatrix(state, Simd::fill(2))),
        stretch_(calcStretch(F, R_).symmetric),
        pressure_(lambda_ * (calcTrace(stretch_) - Simd::fill(3)) - Simd::fill(2) * mu_),
        stress_(addDiagonal(Simd::fill(2) * mu_ * stretch_, pressure_)) {}

  /// To be called before blocks are asked for. Returns those of the `active` elements whose blocks are what was asked
  /// for; those of the others are finite.
  SimdMask updateTangent(SimdMask active, bool exact) {
    constexpr double kLargestTurning = 100;  // of mu; beyond it the element is all but inverted
    const Symmetric G = calcTurningMetric(stretch_);
    const Symmetric adjugate = calcAdjugate(G);
    const Simd factor = select(active, pressure_ / calcDeterminant(G, adjugate), Simd::fill(0));
    turning_ = addDiagonal(factor * adjugate, mu_);
    const Simd largest = Simd::fill(kLargestTurning) * mu_;
    const SimdMask usable = active & (calcSquaredNorm(turning_) < largest * largest);
    return exact ? usable : usable & isPositive(turning_);
  }

  Triple push(const Triple& gradient) const { return R_ * gradient; }

  Triple calcTraction(const Triple& q) const { return stress_ * q; }

  Prepared prepare(const Triple& q) const { return {lambda_ * q, mu_ * q, timesCross(turning_, q)}; }

  Matrix calcBlock(const Triple& q, const Prepared& other) const {
    const Simd zero = Simd::fill(0);
    const Simd diagonal = dot(q, other.mu);
    const Simd along[3] = {q.x, q.y, q.z};
    const Simd across[3] = {other.lambda.x, other.lambda.y, other.lambda.z};
    Matrix block = {{{diagonal, zero, zero}, {zero, diagonal, zero}, {zero, zero, diagonal}}};
    for (int j = 0; j < 3; ++j) {
      Triple& column = block.columns[j];
      column = multiplyAdd(across[j], q, column);
      column = multiplyAdd(along[j], other.mu, column);
      column = crossAdd(other.turning.columns[j], q, column);
    }
    return block;
  }

 private:
  Simd lambda_, mu_;
  Matrix R_;
  Symmetric stretch_;  // R sym(R^T F) R^T
  Simd pressure_;      // lambda tr(e) - 2 mu
  Symmetric stress_;   // R sigma R^T
  Symmetric turning_;  // R Q R^T
};

}  // namespace SINEW_ISA
}  // namespace sinew
