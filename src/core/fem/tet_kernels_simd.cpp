#include "sinew/fem/corotational_law.h"
#include "sinew/fem/tet_kernels.h"

namespace sinew {
namespace SINEW_ISA {
namespace {

constexpr int kParts = 2;  // vectors of elements whose states are updated together

struct Shape {
  Triple gradients[3];  // of nodes 1 2 3
  Simd volume;
};

Shape loadShape(const TetBatch& batch, int lane) {
  Shape shape;
  for (int a = 0; a < 3; ++a) {
    shape.gradients[a] = {Simd::load(batch.gradients[3 * a] + lane), Simd::load(batch.gradients[3 * a + 1] + lane),
                          Simd::load(batch.gradients[3 * a + 2] + lane)};
  }
  shape.volume = Simd::load(batch.volume + lane);
  return shape;
}

Triple loadPosition(const double* positions, const unsigned* place) {
  Triple x;
  loadTriples(positions, place, x.x, x.y, x.z);
  return x;
}

// F = sum of (x_a - x_0) g_a^T. Both kernels use it; as a call it would take its vectors through memory.
[[gnu::always_inline]] inline Matrix calcDeformation(const Shape& shape, const TetBatch& batch, int lane,
                                                     const double* positions) {
  const Triple origin = loadPosition(positions, batch.position[0] + lane);
  Matrix edges;
  for (int a = 0; a < 3; ++a) edges.columns[a] = loadPosition(positions, batch.position[a + 1] + lane) - origin;
  const Triple* g = shape.gradients;
  return {{edges * Triple{g[0].x, g[1].x, g[2].x}, edges * Triple{g[0].y, g[1].y, g[2].y},
           edges * Triple{g[0].z, g[1].z, g[2].z}}};
}

Simd loadFree(const TetBatch& batch, int node, int lane) {
  return Simd::load(batch.free[node] + lane);
}

// Four numbers are added at a time, one of them zero: behind the first two columns, where the block goes on, and before
// the last one.
void addBlock(const Matrix& block, const unsigned* first, const unsigned* stride, double* tangent) {
  const Simd zero = Simd::fill(0);
  const Triple* c = block.columns;
  unsigned second[Simd::kWidth], before_third[Simd::kWidth];
  for (int i = 0; i < Simd::kWidth; ++i) {
    second[i] = first[i] + stride[i];
    before_third[i] = second[i] + stride[i] - 1;
  }
  addFours(c[0].x, c[0].y, c[0].z, zero, tangent, first);
  addFours(c[1].x, c[1].y, c[1].z, zero, tangent, second);
  addFours(zero, c[2].x, c[2].y, c[2].z, tangent, before_third);
}

template <class Law>
[[gnu::always_inline]] inline void addForces(const Law& law, const Triple (&q)[4], Simd weight, const TetBatch& batch,
                                             int lane, double* forces) {
  Triple f[4];
  for (int a = 0; a < 4; ++a) {
    const Simd factor = batch.any_fixed ? weight * loadFree(batch, a, lane) : weight;
    f[a] = (Simd::fill(0) - factor) * law.calcTraction(q[a]);
  }
  for (int a = 0; a < 4; ++a) addFours(f[a].x, f[a].y, f[a].z, Simd::fill(0), forces, batch.force[a] + lane);
}

// Block after block, so that the processor calculates one while it still stores another.
template <class Law>
void addBlocks(const Law& law, const Triple (&q)[4], Simd weight, const TetBatch& batch, int lane, double* tangent) {
  for (int b = 0; b < 4; ++b) {
    const typename Law::Prepared prepared = law.prepare(weight * q[b]);
    for (int a = b; a < 4; ++a) {
      const int k = a * (a + 1) / 2 + b;
      Matrix block = law.calcBlock(q[a], prepared);
      if (batch.any_fixed) {
        const Simd factor = loadFree(batch, a, lane) * loadFree(batch, b, lane);
        for (Triple& column : block.columns) column = factor * column;
      }
      addBlock(block, batch.first[k] + lane, batch.stride[k] + lane, tangent);
    }
  }
}

template <class Law, bool kWithTangent>
SimdMask addPart(Law& law, const Shape& shape, SimdMask usable, const TetBatch& batch, int lane,
                 const TetAssembly& assembly) {
  if (kWithTangent) usable = law.updateTangent(usable, assembly.exact);
  const Simd weight = select(usable, shape.volume, Simd::fill(0));
  Triple q[4];
  for (int a = 1; a < 4; ++a) q[a] = law.push(shape.gradients[a - 1]);
  q[0] = Simd::fill(-1) * (q[1] + q[2] + q[3]);
  addForces(law, q, weight, batch, lane, assembly.forces);
  if (kWithTangent) addBlocks(law, q, weight, batch, lane, assembly.tangent);
  return usable;
}

template <class Law, bool kWithTangent>
unsigned addParts(const TetBatch& batch, int lane, RotationBatch& rotations, const TetAssembly& assembly) {
  Shape shapes[kParts];
  Matrix F[kParts];
  typename Law::State states[kParts];
  SimdMask active[kParts], usable[kParts];
  for (int k = 0; k < kParts; ++k) {
    const int at = lane + k * Simd::kWidth;
    shapes[k] = loadShape(batch, at);
    F[k] = calcDeformation(shapes[k], batch, at, assembly.positions);
    states[k] = Law::loadState(rotations, at);
    active[k] = usable[k] = Simd::fill(0) < shapes[k].volume;
  }
  Law::updateStates(F, usable, states);
  unsigned left = 0;
  for (int k = 0; k < kParts; ++k) {
    const int at = lane + k * Simd::kWidth;
    Law::storeState(states[k], rotations, at);
    Law law(batch, at, F[k], states[k]);
    const SimdMask added = addPart<Law, kWithTangent>(law, shapes[k], usable[k], batch, at, assembly);
    left |= (toBits(active[k]) & ~toBits(added)) << at;
  }
  return left;
}

template <class Law, bool kWithTangent>
unsigned addBatch(const TetBatch& batch, RotationBatch& rotations, const TetAssembly& assembly) {
  unsigned left = 0;
  for (int lane = 0; lane < TetBatch::kSize; lane += kParts * Simd::kWidth) {
    left |= addParts<Law, kWithTangent>(batch, lane, rotations, assembly);
  }
  return left;
}

}  // namespace

TetKernels tetKernels() {
  return {addBatch<CorotationalLaw, true>, addBatch<CorotationalLaw, false>};
}

}  // namespace SINEW_ISA
}  // namespace sinew
