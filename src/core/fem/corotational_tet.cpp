#include "sinew/fem/corotational_tet.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sinew/fem/rotation.h"

namespace sinew {
namespace {

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

// Q of the turning stiffness in the rotated-back frame, without its negative eigenvalues; false when none is left. To
// first order in the strain the eigenvalues are the sums of two principal stresses over (s_i + s_j).
bool calcTurningStiffness(const Lame& lame, const Mat3& S, Mat3& Q) {
  Eigen::SelfAdjointEigenSolver<Mat3> principal;
  principal.computeDirect(S);
  const Vec3& s = principal.eigenvalues();
  const double pressure = lame.lambda * (s.sum() - 3) - 2 * lame.mu;
  Vec3 q;
  for (int i = 0; i < 3; ++i) {
    const double pair = s[(i + 1) % 3] + s[(i + 2) % 3];
    q[i] = pair > 0 ? std::max(0.0, lame.mu + pressure / pair) : 0.0;
  }
  if (q.maxCoeff() <= 0) return false;
  Q = principal.eigenvectors() * q.asDiagonal() * principal.eigenvectors().transpose();
  return true;
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

void calcTetLinearisation(const TetShape& shape, const Lame& lame, const TetGradients& positions, Mat3& R,
                          TetLinearisation& result) {
  const Mat3 S = updateStretch(shape, positions, R);
  result.forces.noalias() = (-shape.volume * R * calcStress(lame, S)) * shape.gradients;

  const TetGradients q = R * shape.gradients;
  Mat3 Q = Mat3::Zero();
  const bool turning = calcTurningStiffness(lame, S, Q);
  if (turning) Q = R * Q * R.transpose();
  for (int a = 0, k = 0; a < 4; ++a) {
    const Vec3 scaled = shape.volume * q.col(a);
    Mat3 turn = Mat3::Zero();
    if (turning) turn = cross(scaled).transpose() * Q;
    for (int b = 0; b <= a; ++b, ++k) {
      Mat3& block = result.stiffness[k];
      block.noalias() = lame.lambda * scaled * q.col(b).transpose() + lame.mu * q.col(b) * scaled.transpose();
      block.diagonal().array() += lame.mu * scaled.dot(q.col(b));
      if (turning) block += turn * cross(q.col(b));
    }
  }
}

}  // namespace sinew
