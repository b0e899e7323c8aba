#pragma once

// Vectors and 3x3 matrices of as many elements as a Simd has lanes; as simd.h, for code that is compiled once per
// instruction set.

#include "sinew/linalg/simd.h"

namespace sinew {
namespace SINEW_ISA {

struct Triple {
  Simd x, y, z;
};

struct Matrix {
  Triple columns[3];
};

struct Symmetric {
  Simd xx, yy, zz, yz, xz, xy;
};

inline Triple operator+(const Triple& a, const Triple& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Triple operator-(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Triple operator*(Simd factor, const Triple& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}

/// factor a + b
inline Triple multiplyAdd(Simd factor, const Triple& a, const Triple& b) {
  return {multiplyAdd(factor, a.x, b.x), multiplyAdd(factor, a.y, b.y), multiplyAdd(factor, a.z, b.z)};
}

inline Simd dot(const Triple& a, const Triple& b) {
  return multiplyAdd(a.x, b.x, multiplyAdd(a.y, b.y, a.z * b.z));
}

/// a x b + c
inline Triple crossAdd(const Triple& a, const Triple& b, const Triple& c) {
  return {multiplySubtract(a.z, b.y, multiplyAdd(a.y, b.z, c.x)),
          multiplySubtract(a.x, b.z, multiplyAdd(a.z, b.x, c.y)),
          multiplySubtract(a.y, b.x, multiplyAdd(a.x, b.y, c.z))};
}

inline Matrix transposed(const Matrix& m) {
  const Triple* c = m.columns;
  return {{{c[0].x, c[1].x, c[2].x}, {c[0].y, c[1].y, c[2].y}, {c[0].z, c[1].z, c[2].z}}};
}

inline Triple operator*(const Matrix& m, const Triple& a) {
  return multiplyAdd(a.x, m.columns[0], multiplyAdd(a.y, m.columns[1], a.z * m.columns[2]));
}

inline Matrix toMatrix(const Symmetric& s) {
  return {{{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}};
}

inline Triple operator*(const Symmetric& s, const Triple& a) {
  return toMatrix(s) * a;
}

inline Symmetric operator*(Simd factor, const Symmetric& s) {
  return {factor * s.xx, factor * s.yy, factor * s.zz, factor * s.yz, factor * s.xz, factor * s.xy};
}

/// s + diagonal I
inline Symmetric addDiagonal(const Symmetric& s, Simd diagonal) {
  return {s.xx + diagonal, s.yy + diagonal, s.zz + diagonal, s.yz, s.xz, s.xy};
}

inline Simd calcTrace(const Symmetric& s) {
  return s.xx + s.yy + s.zz;
}

inline Simd calcSquaredNorm(const Symmetric& s) {
  const Triple diagonal = {s.xx, s.yy, s.zz};
  const Triple mixed = {s.yz, s.xz, s.xy};
  return multiplyAdd(Simd::fill(2), dot(mixed, mixed), dot(diagonal, diagonal));
}

/// s adjugate(s) = det(s) I
inline Symmetric calcAdjugate(const Symmetric& s) {
  return {multiplySubtract(s.yz, s.yz, s.yy * s.zz), multiplySubtract(s.xz, s.xz, s.xx * s.zz),
          multiplySubtract(s.xy, s.xy, s.xx * s.yy), multiplySubtract(s.xx, s.yz, s.xy * s.xz),
          multiplySubtract(s.xz, s.yy, s.xy * s.yz), multiplySubtract(s.xy, s.zz, s.xz * s.yz)};
}

inline Simd calcDeterminant(const Symmetric& s, const Symmetric& adjugate) {
  return dot({s.xx, s.xy, s.xz}, {adjugate.xx, adjugate.xy, adjugate.xz});
}

/// Positive definite, by the leading minors.
inline SimdMask isPositive(const Symmetric& s) {
  const Simd zero = Simd::fill(0);
  const Symmetric adjugate = calcAdjugate(s);
  return (zero < s.xx) & (zero < adjugate.zz) & (zero < calcDeterminant(s, adjugate));
}

/// s [a]x
inline Matrix timesCross(const Symmetric& s, const Triple& a) {
  const Matrix m = toMatrix(s);
  const Triple* c = m.columns;
  return {{a.z * c[1] - a.y * c[2], a.x * c[2] - a.z * c[0], a.y * c[0] - a.x * c[1]}};
}

}  // namespace SINEW_ISA
}  // namespace sinew
