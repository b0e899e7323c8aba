#pragma once

#include "sinew/fem/simd_matrix.h"

namespace sinew {
namespace SINEW_ISA {

/// w + x i + y j + z k; any length but zero stands for a rotation.
struct Quaternion {
  Simd w;
  Triple v;
};

inline Quaternion select(SimdMask mask, const Quaternion& a, const Quaternion& b) {
  return {select(mask, a.w, b.w), {select(mask, a.v.x, b.v.x), select(mask, a.v.y, b.v.y), select(mask, a.v.z, b.v.z)}};
}

inline Quaternion normalised(const Quaternion& q) {
  const Simd scale = Simd::fill(1) / sqrt(multiplyAdd(q.w, q.w, dot(q.v, q.v)));
  return {scale * q.w, scale * q.v};
}

/// `scale` = 2 / |q|^2
inline Matrix calcMatrix(const Quaternion& q, Simd scale) {
  const Simd one = Simd::fill(1);
  const Triple s = scale * q.v;
  const Triple w = q.w * s;
  const Simd xx = s.x * q.v.x, yy = s.y * q.v.y, zz = s.z * q.v.z;
  const Simd yz = s.y * q.v.z, xz = s.x * q.v.z, xy = s.x * q.v.y;
  return {{{one - (yy + zz), xy + w.z, xz - w.y},
           {xy - w.z, one - (xx + zz), yz + w.x},
           {xz + w.y, yz - w.x, one - (xx + yy)}}};
}

/// (1, h) q: turned on by Cayley's map of the rotation vector 2 h.
inline Quaternion turned(const Triple& h, const Quaternion& q) {
  return {q.w - dot(h, q.v), crossAdd(h, q.v, multiplyAdd(q.w, h, q.v))};
}

/// M = F R^T in its two parts.
struct Stretch {
  Symmetric symmetric;  ///< (M + M^T) / 2
  Triple axial;         ///< of M - M^T
};

inline Stretch calcStretch(const Matrix& F, const Matrix& R) {
  const Triple *f = F.columns, *r = R.columns;
  const Triple fx = {f[0].x, f[1].x, f[2].x}, fy = {f[0].y, f[1].y, f[2].y}, fz = {f[0].z, f[1].z, f[2].z};
  const Triple rx = {r[0].x, r[1].x, r[2].x}, ry = {r[0].y, r[1].y, r[2].y}, rz = {r[0].z, r[1].z, r[2].z};
  const Simd yz = dot(fy, rz), zy = dot(fz, ry), xz = dot(fx, rz), zx = dot(fz, rx), xy = dot(fx, ry), yx = dot(fy, rx);
  const Triple mixed = Simd::fill(0.5) * Triple{yz + zy, xz + zx, xy + yx};
  return {{dot(fx, rx), dot(fy, ry), dot(fz, rz), mixed.x, mixed.y, mixed.z}, {zy - yz, xz - zx, yx - xy}};
}

/// tr(S) I - S, through which a turn changes the axial part.
inline Symmetric calcTurningMetric(const Symmetric& S) {
  const Simd zero = Simd::fill(0);
  return {S.yy + S.zz, S.xx + S.zz, S.xx + S.yy, zero - S.yz, zero - S.xz, zero - S.xy};
}

/// The search for a rotation on its way.
struct Turning {
  Quaternion q;
  Simd scale;        ///< 2 / |q|^2
  SimdMask moving;   ///< lanes that are still to be turned
  SimdMask arrived;  ///< lanes that have their rotation
};

/// A step of Newton's iteration. It converges cubically: the third derivative of tr(R^T F) by the turn is as small as
/// the residual, tr([w]x^3 S) = -|w|^2 tr([w]x S). A lane that is not definite enough, or turns too far, does not move
/// any more.
inline void turnOnce(const Matrix& F, Turning& turning) {
  constexpr double kLeastDeterminant = 1e-3;  // of tr(S)^3; 8/27 at rest
  constexpr double kSmallTurn = 1e-11 / 4;    // |h|^2: the error left, of third order, is below rounding
  const Simd zero = Simd::fill(0), one = Simd::fill(1), small = Simd::fill(kSmallTurn);
  const Stretch stretch = calcStretch(F, calcMatrix(turning.q, turning.scale));
  const Symmetric G = calcTurningMetric(stretch.symmetric);
  const Symmetric adjugate = calcAdjugate(G);
  const Simd determinant = calcDeterminant(G, adjugate);
  const Triple h = Simd::fill(0.5) / determinant * (adjugate * stretch.axial);
  const Simd turn = dot(h, h);

  const Simd size = calcTrace(stretch.symmetric);
  const Simd least = Simd::fill(kLeastDeterminant) * size * size * size;
  const SimdMask definite = (zero < size) & (zero < G.xx) & (zero < adjugate.zz) & (least < determinant);
  const SimdMask moving = turning.moving & definite & (turn < one);
  turning.q = select(moving, turned(h, turning.q), turning.q);
  turning.scale = select(moving, turning.scale / (one + turn), turning.scale);
  turning.arrived = turning.arrived | (moving & (turn < small));
  turning.moving = moving & (small < turn);
}

/// As updateRotation of rotation.h, from the left: with M = F R^T the turn w solves (tr(M) I - sym M) w = axial(M -
/// M^T). Several at a time, because one alone mostly waits for its own last result. Turns the lanes of `active`, whose
/// quaternions are of unit length, and leaves active those that arrived; the others keep the rotation they had.
template <int kCount>
inline void updateRotations(const Matrix (&F)[kCount], SimdMask (&active)[kCount], Quaternion (&rotations)[kCount]) {
  constexpr int kMaxIterations = 8;
  const SimdMask none = Simd::fill(1) < Simd::fill(0);
  Turning turning[kCount];
  for (int k = 0; k < kCount; ++k) turning[k] = {rotations[k], Simd::fill(2), active[k], none};
  unsigned moving = 1;
  for (int i = 0; i < kMaxIterations && moving != 0; ++i) {
    moving = 0;
    for (int k = 0; k < kCount; ++k) {
      turnOnce(F[k], turning[k]);
      moving |= toBits(turning[k].moving);
    }
  }
  for (int k = 0; k < kCount; ++k) {
    active[k] = turning[k].arrived;
    rotations[k] = select(turning[k].arrived, normalised(turning[k].q), rotations[k]);
  }
}

}  // namespace SINEW_ISA
}  // namespace sinew
