#pragma once

// A few doubles that are computed on at once: the only file that knows the instruction set. For translation units that
// are compiled once per set, with SINEW_ISA the name of their own: everything they define lies in the namespace of that
// name, and they include neither Eigen nor templates of the standard library, of which the linker would keep one copy
// for all.

#if !defined(SINEW_ISA)
#error "simd.h is for code that is compiled once per instruction set"
#endif

#if defined(__AVX512F__) || (defined(__AVX2__) && defined(__FMA__))
#define SINEW_HAS_AVX
// gcc takes the undefined lanes of its own headers for uninitialised variables
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

namespace sinew {
namespace SINEW_ISA {

#if defined(SINEW_HAS_AVX)

/// Three numbers of four lanes.
struct QuadTriples {
  __m256d x, y, z;
};

inline __m256d joinPairs(const double* low, const double* high) {
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(low)), _mm_loadu_pd(high), 1);
}
inline QuadTriples loadQuadTriples(const double* from, const unsigned* place) {
  const double* const at[4] = {from + place[0], from + place[1], from + place[2], from + place[3]};
  const __m256d even = joinPairs(at[0], at[2]);
  const __m256d odd = joinPairs(at[1], at[3]);
  return {_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd),
          _mm256_setr_pd(at[0][2], at[1][2], at[2][2], at[3][2])};
}
inline void addFour(__m256d four, double* to) {
  _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), four));
}
inline void addQuadFours(__m256d a, __m256d b, __m256d c, __m256d d, double* to, const unsigned* place) {
  const __m256d ab_even = _mm256_unpacklo_pd(a, b);
  const __m256d ab_odd = _mm256_unpackhi_pd(a, b);
  const __m256d cd_even = _mm256_unpacklo_pd(c, d);
  const __m256d cd_odd = _mm256_unpackhi_pd(c, d);
  addFour(_mm256_permute2f128_pd(ab_even, cd_even, 0x20), to + place[0]);
  addFour(_mm256_permute2f128_pd(ab_odd, cd_odd, 0x20), to + place[1]);
  addFour(_mm256_permute2f128_pd(ab_even, cd_even, 0x31), to + place[2]);
  addFour(_mm256_permute2f128_pd(ab_odd, cd_odd, 0x31), to + place[3]);
}

#endif

#if defined(__AVX512F__)

struct SimdMask {
  __mmask8 bits;
};

struct Simd {
  static constexpr int kWidth = 8;
  __m512d lanes;

  static Simd fill(double value) { return {_mm512_set1_pd(value)}; }
  static Simd load(const double* from) { return {_mm512_loadu_pd(from)}; }
  /// The first `count` < kWidth; the others are 0 and not read.
  static Simd loadHead(const double* from, int count) { return {_mm512_maskz_loadu_pd(head(count), from)}; }
  void store(double* to) const { _mm512_storeu_pd(to, lanes); }
  void storeHead(double* to, int count) const { _mm512_mask_storeu_pd(to, head(count), lanes); }

 private:
  static __mmask8 head(int count) { return static_cast<__mmask8>((1U << count) - 1U); }
};

inline Simd operator+(Simd a, Simd b) {
  return {_mm512_add_pd(a.lanes, b.lanes)};
}
inline Simd operator-(Simd a, Simd b) {
  return {_mm512_sub_pd(a.lanes, b.lanes)};
}
inline Simd operator*(Simd a, Simd b) {
  return {_mm512_mul_pd(a.lanes, b.lanes)};
}
inline Simd operator/(Simd a, Simd b) {
  return {_mm512_div_pd(a.lanes, b.lanes)};
}
/// a b + c
inline Simd multiplyAdd(Simd a, Simd b, Simd c) {
  return {_mm512_fmadd_pd(a.lanes, b.lanes, c.lanes)};
}
/// c - a b
inline Simd multiplySubtract(Simd a, Simd b, Simd c) {
  return {_mm512_fnmadd_pd(a.lanes, b.lanes, c.lanes)};
}
inline SimdMask operator<(Simd a, Simd b) {
  return {_mm512_cmp_pd_mask(a.lanes, b.lanes, _CMP_LT_OQ)};
}
inline SimdMask operator&(SimdMask a, SimdMask b) {
  return {static_cast<__mmask8>(a.bits & b.bits)};
}
inline unsigned toBits(SimdMask mask) {
  return mask.bits;
}  ///< lane i at bit i
/// `a` where the mask is set, else `b`.
inline Simd select(SimdMask mask, Simd a, Simd b) {
  return {_mm512_mask_blend_pd(mask.bits, b.lanes, a.lanes)};
}
inline SimdMask operator|(SimdMask a, SimdMask b) {
  return {static_cast<__mmask8>(a.bits | b.bits)};
}
inline Simd sqrt(Simd a) {
  return {_mm512_sqrt_pd(a.lanes)};
}
/// Three neighbouring numbers for every lane, those of lane i from from[place[i]] on.
inline void loadTriples(const double* from, const unsigned* place, Simd& x, Simd& y, Simd& z) {
  const QuadTriples low = loadQuadTriples(from, place), high = loadQuadTriples(from, place + 4);
  x.lanes = _mm512_insertf64x4(_mm512_castpd256_pd512(low.x), high.x, 1);
  y.lanes = _mm512_insertf64x4(_mm512_castpd256_pd512(low.y), high.y, 1);
  z.lanes = _mm512_insertf64x4(_mm512_castpd256_pd512(low.z), high.z, 1);
}
/// Adds four numbers of every lane to those from to[place[i]] on, one lane after the other: places may coincide.
inline void addFours(Simd a, Simd b, Simd c, Simd d, double* to, const unsigned* place) {
  addQuadFours(_mm512_castpd512_pd256(a.lanes), _mm512_castpd512_pd256(b.lanes), _mm512_castpd512_pd256(c.lanes),
               _mm512_castpd512_pd256(d.lanes), to, place);
  addQuadFours(_mm512_extractf64x4_pd(a.lanes, 1), _mm512_extractf64x4_pd(b.lanes, 1),
               _mm512_extractf64x4_pd(c.lanes, 1), _mm512_extractf64x4_pd(d.lanes, 1), to, place + 4);
}

#elif defined(SINEW_HAS_AVX)

struct SimdMask {
  __m256d bits;
};

struct Simd {
  static constexpr int kWidth = 4;
  __m256d lanes;

  static Simd fill(double value) { return {_mm256_set1_pd(value)}; }
  static Simd load(const double* from) { return {_mm256_loadu_pd(from)}; }
  /// The first `count` < kWidth; the others are 0 and not read.
  static Simd loadHead(const double* from, int count) { return {_mm256_maskload_pd(from, head(count))}; }
  void store(double* to) const { _mm256_storeu_pd(to, lanes); }
  void storeHead(double* to, int count) const { _mm256_maskstore_pd(to, head(count), lanes); }

 private:
  static __m256i head(int count) {
    return _mm256_cmpgt_epi64(_mm256_set1_epi64x(count), _mm256_setr_epi64x(0, 1, 2, 3));
  }
};

inline Simd operator+(Simd a, Simd b) {
  return {_mm256_add_pd(a.lanes, b.lanes)};
}
inline Simd operator-(Simd a, Simd b) {
  return {_mm256_sub_pd(a.lanes, b.lanes)};
}
inline Simd operator*(Simd a, Simd b) {
  return {_mm256_mul_pd(a.lanes, b.lanes)};
}
inline Simd operator/(Simd a, Simd b) {
  return {_mm256_div_pd(a.lanes, b.lanes)};
}
inline Simd multiplyAdd(Simd a, Simd b, Simd c) {
  return {_mm256_fmadd_pd(a.lanes, b.lanes, c.lanes)};
}
inline Simd multiplySubtract(Simd a, Simd b, Simd c) {
  return {_mm256_fnmadd_pd(a.lanes, b.lanes, c.lanes)};
}
inline SimdMask operator<(Simd a, Simd b) {
  return {_mm256_cmp_pd(a.lanes, b.lanes, _CMP_LT_OQ)};
}
inline SimdMask operator&(SimdMask a, SimdMask b) {
  return {_mm256_and_pd(a.bits, b.bits)};
}
inline unsigned toBits(SimdMask mask) {
  return static_cast<unsigned>(_mm256_movemask_pd(mask.bits));
}
inline Simd select(SimdMask mask, Simd a, Simd b) {
  return {_mm256_blendv_pd(b.lanes, a.lanes, mask.bits)};
}
inline SimdMask operator|(SimdMask a, SimdMask b) {
  return {_mm256_or_pd(a.bits, b.bits)};
}
inline Simd sqrt(Simd a) {
  return {_mm256_sqrt_pd(a.lanes)};
}
inline void loadTriples(const double* from, const unsigned* place, Simd& x, Simd& y, Simd& z) {
  const QuadTriples triples = loadQuadTriples(from, place);
  x.lanes = triples.x;
  y.lanes = triples.y;
  z.lanes = triples.z;
}
inline void addFours(Simd a, Simd b, Simd c, Simd d, double* to, const unsigned* place) {
  addQuadFours(a.lanes, b.lanes, c.lanes, d.lanes, to, place);
}

#else

// Two lanes in the compiler's own terms: SSE2, NEON, or whatever the machine has.
typedef double SimdLanes __attribute__((vector_size(16)));
typedef long long SimdBits __attribute__((vector_size(16)));

struct SimdMask {
  SimdBits bits;
};

struct Simd {
  static constexpr int kWidth = 2;
  SimdLanes lanes;

  static Simd fill(double value) { return {SimdLanes{value, value}}; }
  static Simd load(const double* from) {
    SimdLanes lanes;
    __builtin_memcpy(&lanes, from, sizeof lanes);
    return {lanes};
  }
  /// The first `count` < kWidth; the others are 0 and not read.
  static Simd loadHead(const double* from, int count) { return {SimdLanes{count > 0 ? *from : 0.0, 0.0}}; }
  void store(double* to) const { __builtin_memcpy(to, &lanes, sizeof lanes); }
  void storeHead(double* to, int count) const {
    if (count > 0) *to = lanes[0];
  }
};

inline Simd operator+(Simd a, Simd b) {
  return {a.lanes + b.lanes};
}
inline Simd operator-(Simd a, Simd b) {
  return {a.lanes - b.lanes};
}
inline Simd operator*(Simd a, Simd b) {
  return {a.lanes * b.lanes};
}
inline Simd operator/(Simd a, Simd b) {
  return {a.lanes / b.lanes};
}
inline Simd multiplyAdd(Simd a, Simd b, Simd c) {
  return {a.lanes * b.lanes + c.lanes};
}
inline Simd multiplySubtract(Simd a, Simd b, Simd c) {
  return {c.lanes - a.lanes * b.lanes};
}
inline SimdMask operator<(Simd a, Simd b) {
  return {a.lanes < b.lanes};
}
inline SimdMask operator&(SimdMask a, SimdMask b) {
  return {a.bits & b.bits};
}
inline unsigned toBits(SimdMask mask) {
  return (mask.bits[0] != 0 ? 1U : 0U) | (mask.bits[1] != 0 ? 2U : 0U);
}
inline Simd select(SimdMask mask, Simd a, Simd b) {
  return {(SimdLanes)(((SimdBits)a.lanes & mask.bits) | ((SimdBits)b.lanes & ~mask.bits))};
}
inline SimdMask operator|(SimdMask a, SimdMask b) {
  return {a.bits | b.bits};
}
inline Simd sqrt(Simd a) {
  return {SimdLanes{__builtin_sqrt(a.lanes[0]), __builtin_sqrt(a.lanes[1])}};
}
inline void loadTriples(const double* from, const unsigned* place, Simd& x, Simd& y, Simd& z) {
  const double* const at[2] = {from + place[0], from + place[1]};
  x.lanes = SimdLanes{at[0][0], at[1][0]};
  y.lanes = SimdLanes{at[0][1], at[1][1]};
  z.lanes = SimdLanes{at[0][2], at[1][2]};
}
inline void addFours(Simd a, Simd b, Simd c, Simd d, double* to, const unsigned* place) {
  for (int i = 0; i < 2; ++i) {
    double* const at = to + place[i];
    (Simd::load(at) + Simd{SimdLanes{a.lanes[i], b.lanes[i]}}).store(at);
    (Simd::load(at + 2) + Simd{SimdLanes{c.lanes[i], d.lanes[i]}}).store(at + 2);
  }
}

#endif

/// Of all lanes.
inline double sum(Simd value) {
  double lanes[Simd::kWidth];
  value.store(lanes);
  double total = 0;
  for (double lane : lanes) total += lane;
  return total;
}

constexpr unsigned kAllLanes = (1U << Simd::kWidth) - 1U;

}  // namespace SINEW_ISA
}  // namespace sinew
