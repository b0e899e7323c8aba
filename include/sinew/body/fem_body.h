#pragma once

#include <memory>
#include <vector>

#include "sinew/fem/fem_model.h"
#include "sinew/linalg/sparse_cholesky.h"

namespace sinew {

/// How a body advances: to equilibrium at once, or by backward Euler with mass and Rayleigh damping.
struct StepRule {
  bool dynamic = false;
  double period = 0;             ///< s
  double damping_mass = 0;       ///< 1/s
  double damping_stiffness = 0;  ///< s
};

/// A soft body that moves: positions, velocities, and one linear system per step. Unknown is the motion dx of the free
/// nodes [m],  A dx = b:
///   static   A = K,  b = f + f_ext
///   dynamic  A = (1 + beta/h) K + (1/h^2 + alpha/h) M,  b = f + f_ext + M (v - (x - x0)/h)/h - D (x - x0)/h
/// with D = alpha M + beta K, x0 the position at the start of the step and x that of the present iterate: backward
/// Euler solved for dx = h dv, so that W = H A^-1 H^T and efforts are forces in both. Actuators add their efforts to
/// `load()` and their load stiffness to `matrix()` between `linearise` and `factorise`.
class FemBody {
 public:
  /// `max_rows`: of the rows that its compliance will be asked for.
  FemBody(const FemModel& model, const Vec3& gravity, int max_rows = 0,
          CholeskyMethod method = CholeskyMethod::kSupernodal, int threads = 1);

  const FemModel& model() const { return *model_; }
  const std::vector<Vec3>& positions() const { return positions_; }
  const VecX& gravityForce() const { return gravity_force_; }
  /// Of the frame that the positions are told in [m/s2]: a force on every mass, against it.
  void setFrameAcceleration(const Vec3& acceleration);

  /// Marks the present configuration as the start of a step; `linearise` and `advance` may then repeat within it.
  void beginStep();
  void linearise(const StepRule& rule, Tangent tangent = Tangent::kExact);
  /// For a static step: b at the present configuration, with `matrix()` and its factor left as they were.
  void updateLoad();
  VecX& load() { return load_; }  ///< b, natural order
  const VecX& load() const { return load_; }
  BlockMatrix& matrix() { return data_.tangent; }  ///< A
  /// Elastic and gravity forces of the linearisation point, without inertia: with the actuators' it is the imbalance.
  VecX& imbalance() { return imbalance_; }
  bool factorise() { return cholesky_->factorise(data_.tangent); }
  SparseCholesky& cholesky() { return *cholesky_; }

  /// Moves the free nodes by `scale` dx, where `scale` <= 1 keeps every node's way below `max_node_step`; returns it.
  double advance(const VecX& motion, double max_node_step);
  /// Closes the step: velocities from the way since `beginStep`. A static body has none.
  void endStep(const StepRule& rule);
  /// Returns to the configuration in which the step began.
  void abandonStep();
  /// At rest at `positions` [m, every mesh node].
  void place(const std::vector<Vec3>& positions);
  /// Back to the rest configuration.
  void reset() { place(model_->rest()); }

 private:
  const FemModel* model_;
  FemData data_;
  std::unique_ptr<SparseCholesky> cholesky_;
  std::vector<Vec3> positions_;
  std::vector<Vec3> start_;
  VecX velocity_;
  Vec3 gravity_;
  VecX gravity_force_;
  VecX load_;
  VecX imbalance_;
  VecX way_;
};

}  // namespace sinew
