#include "sinew/fem/rotation.h"

#include <Eigen/SVD>
#include <cmath>

namespace sinew {
namespace {

constexpr int kMaxIterations = 8;

Vec3 axialOfSkew(const Mat3& S) {
  return Vec3(S(2, 1) - S(1, 2), S(0, 2) - S(2, 0), S(1, 0) - S(0, 1));
}

Mat3 rotationBySvd(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

// The Cayley map agrees with exp to second order and gives an exact rotation for any w.
Mat3 cayley(const Vec3& w) {
  const Vec3 h = 0.5 * w;
  const double scale = 2.0 / (1.0 + h.squaredNorm());
  Mat3 H;
  H << 0, -h.z(), h.y(), h.z(), 0, -h.x(), -h.y(), h.x(), 0;
  return Mat3::Identity() + scale * (H + H * H);
}

// One step of Newton's iteration to the nearest orthogonal matrix: removes the rounding gathered over many cycles.
Mat3 reorthogonalised(const Mat3& R) {
  return 0.5 * R * (3.0 * Mat3::Identity() - R.transpose() * R);
}

}  // namespace

void updateRotation(const Mat3& F, Mat3& R) {
  for (int i = 0; i < kMaxIterations; ++i) {
    const Mat3 S = R.transpose() * F;
    const Vec3 axial = axialOfSkew(S);
    const double size = S.cwiseAbs().sum();
    Mat3 G = -0.5 * (S + S.transpose());
    G.diagonal().array() += S.trace();
    const double determinant = G.determinant();
    const bool definite =
        G(0, 0) > 0 && G(0, 0) * G(1, 1) - G(0, 1) * G(0, 1) > 0 && determinant > 1e-9 * size * size * size;
    if (!definite) break;
    Mat3 adjugate;  // of the symmetric G: the cross products of its columns
    adjugate.col(0) = G.col(1).cross(G.col(2));
    adjugate.col(1) = G.col(2).cross(G.col(0));
    adjugate.col(2) = G.col(0).cross(G.col(1));
    const Vec3 turn = adjugate * axial / determinant;
    const double angle = turn.squaredNorm();
    if (!(angle < 4.0)) break;
    R = R * cayley(turn);
    if (angle < 1e-14) {  // quadratic convergence: the error left is far below rounding
      R = reorthogonalised(R);
      return;
    }
  }
  R = rotationBySvd(F);
}

}  // namespace sinew
