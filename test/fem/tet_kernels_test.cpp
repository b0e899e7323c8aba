#include "sinew/fem/tet_kernels.h"

#include <gtest/gtest.h>

#include <random>

#include "mesh/bar_mesh.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

class TetKernelsTest : public testing::TestWithParam<InstructionSet> {
 protected:
  TetMesh mesh_ = makeBarMesh(Vec3(5, 2, 1), 5, 2, 1);
  FemModel model_{mesh_,
                  std::vector<Material>(mesh_.tets.size(), {calcLame(1e5, 0.4), 1000}),
                  std::vector<bool>(mesh_.nodes.size(), false),
                  {}};
  FemData data_{model_, GetParam()};

  std::vector<Vec3> deform(const Mat3& F) const {
    std::vector<Vec3> positions;
    for (const Vec3& node : mesh_.nodes) positions.push_back(F * node);
    return positions;
  }

  /// Elements that the kernel leaves.
  int run(const std::vector<Vec3>& positions, bool exact) {
    data_.tangent.setZero();
    data_.kernel_forces.setZero();
    const TetAssembly assembly = {positions.data()->data(), data_.kernel_forces.data(), data_.tangent.values().data(),
                                  exact};
    int count = 0;
    for (std::size_t i = 0; i < model_.batches().size(); ++i) {
      for (unsigned left = data_.kernels.linearise(model_.batches()[i], data_.rotations[i], assembly); left != 0;
           left &= left - 1) {
        ++count;
      }
    }
    return count;
  }

  void expectNothingAdded() const {
    EXPECT_EQ(data_.kernel_forces.cwiseAbs().maxCoeff(), 0);
    for (const double value : data_.tangent.values()) EXPECT_EQ(value, 0);
  }
};

TEST_P(TetKernelsTest, TreatOrdinaryElements) {
  std::vector<Vec3> positions = deform(Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()).toRotationMatrix());
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 0.05);
  for (Vec3& x : positions) x += Vec3(normal(random), normal(random), normal(random));
  EXPECT_EQ(run(positions, true), 0);
  EXPECT_EQ(run(deform(Vec3(1.1, 1.05, 1).asDiagonal()), false), 0);
}

TEST_P(TetKernelsTest, LeaveElementsTurnedTooFar) {
  const std::vector<Vec3> positions = deform(Eigen::AngleAxisd(3, Vec3::UnitX()).toRotationMatrix());
  EXPECT_EQ(run(positions, true), static_cast<int>(mesh_.tets.size()));
  expectNothingAdded();
}

TEST_P(TetKernelsTest, LeaveElementsWithoutARotation) {
  EXPECT_EQ(run(deform(Vec3(1, 1, -1).asDiagonal()), true), static_cast<int>(mesh_.tets.size()));
  expectNothingAdded();
}

TEST_P(TetKernelsTest, LeaveElementsWithoutNumbers) {
  EXPECT_EQ(run(deform(Mat3::Constant(std::nan(""))), true), static_cast<int>(mesh_.tets.size()));
}

// Under compression alone the turning stiffness is negative about every axis.
TEST_P(TetKernelsTest, LeaveNegativeTurningOnlyWhereAskedTo) {
  const std::vector<Vec3> positions = deform(0.5 * Mat3::Identity());
  EXPECT_EQ(run(positions, true), 0);
  EXPECT_EQ(run(positions, false), static_cast<int>(mesh_.tets.size()));
}

INSTANTIATE_TEST_SUITE_P(EveryInstructionSet, TetKernelsTest, testing::ValuesIn(findInstructionSets()),
                         [](const auto& instance) { return nameOf(instance.param); });

}  // namespace
}  // namespace sinew
