#include <Eigen/Geometry>

#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

/// One element's rotation among those of the batches.
struct RotationPlace {
  double* w;

  Mat3 get() const {
    constexpr int kStride = TetBatch::kSize;
    return Eigen::Quaterniond(w[0], w[kStride], w[2 * kStride], w[3 * kStride]).toRotationMatrix();
  }
  void set(const Mat3& R) const {
    constexpr int kStride = TetBatch::kSize;
    const Eigen::Quaterniond q(R);
    w[0] = q.w();
    w[kStride] = q.x();
    w[2 * kStride] = q.y();
    w[3 * kStride] = q.z();
  }
};

RotationBatch makeUnturned() {
  RotationBatch rotations = {};
  for (double& w : rotations.quaternion[0]) w = 1;
  return rotations;
}

TetGradients gather(const FemModel::Element& element, const std::vector<Vec3>& positions) {
  TetGradients x;
  for (int a = 0; a < 4; ++a) x.col(a) = positions[element.nodes[a]];
  return x;
}

void addForces(const FemModel& model, const FemModel::Element& element, const TetGradients& forces, FemData& data) {
  for (int a = 0; a < 4; ++a) {
    const int row = model.freeIndex(element.nodes[a]);
    if (row >= 0) data.kernel_forces.col(row).head<3>() += forces.col(a);
  }
}

void addBlocks(const FemModel::Element& element, const TetLinearisation& result, FemData& data) {
  for (int k = 0; k < 10; ++k) {
    if (element.slots[k].first >= 0) data.tangent.add(element.slots[k], result.stiffness[k]);
  }
}

/// Asks for all cache lines of an object. Its arrays are read across, which a processor does not foresee by itself.
template <class Object>
void prefetch(const Object& object) {
  constexpr std::size_t kLine = 64;  // bytes
  const char* const first = reinterpret_cast<const char*>(&object);
  for (std::size_t at = 0; at < sizeof(Object); at += kLine) __builtin_prefetch(first + at);
}

/// Runs the kernel over the batches, and `add(element, R)` for each element that it leaves.
template <class Add>
void addElements(const FemModel& model, const std::vector<Vec3>& positions, TetKernel kernel, bool exact, FemData& data,
                 Add add) {
  data.kernel_forces.setZero();
  const TetAssembly assembly = {positions.data()->data(), data.kernel_forces.data(), data.tangent.values().data(),
                                exact};
  const std::size_t count = model.batches().size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i + 1 < count) {
      prefetch(model.batches()[i + 1]);
      prefetch(data.rotations[i + 1]);
    }
    unsigned left = kernel(model.batches()[i], data.rotations[i], assembly);
    for (std::size_t lane = 0; left != 0; ++lane, left >>= 1U) {
      if ((left & 1U) == 0) continue;
      const RotationPlace place = {data.rotations[i].quaternion[0] + lane};
      Mat3 R = place.get();
      add(model.elements()[lane * count + i], R);
      place.set(R);
    }
  }
  Eigen::Map<Eigen::Matrix3Xd>(data.force.data(), 3, model.freeCount()) = data.kernel_forces.topRows<3>();
}

}  // namespace

FemData::FemData(const FemModel& model, InstructionSet set)
    : force(VecX::Zero(model.size())),
      tangent(model.pattern()),
      rotations(model.batches().size(), makeUnturned()),
      kernel_forces(4, model.freeCount()),
      kernels(tetKernelsOf(set)) {}

void assemble(const FemModel& model, const std::vector<Vec3>& positions, Tangent tangent, FemData& data) {
  data.tangent.setZero();
  TetLinearisation result;
  const auto add = [&](const FemModel::Element& element, Mat3& R) {
    calcTetLinearisation(element.shape, element.lame, gather(element, positions), tangent, R, result);
    addForces(model, element, result.forces, data);
    addBlocks(element, result, data);
  };
  addElements(model, positions, data.kernels.linearise, tangent == Tangent::kExact, data, add);
}

void assembleForces(const FemModel& model, const std::vector<Vec3>& positions, FemData& data) {
  TetGradients forces;
  const auto add = [&](const FemModel::Element& element, Mat3& R) {
    calcTetForces(element.shape, element.lame, gather(element, positions), R, forces);
    addForces(model, element, forces, data);
  };
  addElements(model, positions, data.kernels.forces, true, data, add);
}

}  // namespace sinew
