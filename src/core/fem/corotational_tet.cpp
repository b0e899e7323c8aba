#include "sinew/fem/corotational_tet.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sinew/fem/rotation.h"

namespace sinew {
namespace {

constexpr double kLargestTurning = 100;  // of mu; beyond it the element is all but inverted

Mat3 cross(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The stretch S = sym(R^T F) after R has been brought up to date with F.
Mat3 updateStretch(const TetShape& shape, const TetGradients& positions, Mat3& R) {
  const Mat3 F = positions * shape.gradients.transpose();
  updateRotation(F, R);
  const Mat3 S = R.transpose() * F;
  return 0.5 * (S + S.transpose());
}

Mat3 calcStress(const Lame& lame, const Mat3& S) {
  Mat3 stress = 2 * lame.mu * S;
  stress.diagonal().array() += lame.lambda * (S.trace() - 3) - 2 * lame.mu;
  return stress;
}

// Q of the turning stiffness in the rotated-back frame. To first order in the strain its eigenvalues are the sums of
// two principal stresses over (s_i + s_j), negative in compression.
Mat3 calcTurningStiffness(const Lame& lame, const Mat3& S, Tangent tangent) {
  const double pressure = lame.lambda * (S.trace() - 3) - 2 * lame.mu;
  if (tangent == Tangent::kExact) {
    Mat3 G = -S;
    G.diagonal().array() += S.trace();
    Mat3 Q = pressure * G.inverse();
    Q.diagonal().array() += lame.mu;
    if (Q.cwiseAbs().maxCoeff() < kLargestTurning * lame.mu) return Q;
  }
  Eigen::SelfAdjointEigenSolver<Mat3> principal;
  principal.computeDirect(S);
  const Vec3& s = principal.eigenvalues();
  Vec3 q;
  for (int i = 0; i < 3; ++i) {
    const double pair = s[(i + 1) % 3] + s[(i + 2) % 3];
    q[i] = pair > 0 ? std::max(0.0, lame.mu + pressure / pair) : 0.0;
  }
  return principal.eigenvectors() * q.asDiagonal() * principal.eigenvectors().transpose();
}

}  // namespace

TetShape makeTetShape(const std::array<Vec3, 4>& rest) {
  Mat3 edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = rest[i + 1] - rest[0];
  TetShape shape;
  shape.volume = std::abs(edges.determinant()) / 6;
  shape.gradients.rightCols<3>() = edges.inverse().transpose();
  shape.gradients.col(0) = -shape.gradients.rightCols<3>().rowwise().sum();
  return shape;
}

void calcTetForces(const TetShape& shape, const Lame& lame, const TetGradients& positions, Mat3& R,
                   TetGradients& forces) {
  const Mat3 S = updateStretch(shape, positions, R);
  forces.noalias() = (-shape.volume * R * calcStress(lame, S)) * shape.gradients;
}

void calcTetLinearisation(const TetShape& shape, const Lame& lame, const TetGradients& positions, Tangent tangent,
                          Mat3& R, TetLinearisation& result) {
  const Mat3 S = updateStretch(shape, positions, R);
  result.forces.noalias() = (-shape.volume * R * calcStress(lame, S)) * shape.gradients;

  const TetGradients q = R * shape.gradients;
  const Mat3 Q = R * calcTurningStiffness(lame, S, tangent) * R.transpose();
  for (int a = 0, k = 0; a < 4; ++a) {
    const Vec3 scaled = shape.volume * q.col(a);
    const Mat3 turn = cross(scaled).transpose() * Q;
    for (int b = 0; b <= a; ++b, ++k) {
      Mat3& block = result.stiffness[k];
      block.noalias() = lame.lambda * scaled * q.col(b).transpose() + lame.mu * q.col(b) * scaled.transpose();
      block.noalias() += turn * cross(q.col(b));
      block.diagonal().array() += lame.mu * scaled.dot(q.col(b));
    }
  }
}

}  // namespace sinew
