#include <gtest/gtest.h>

#include <random>

#include "mesh/bar_mesh.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

using Positions = std::vector<Vec3>;

/// What the elements give one by one, without memory of any rotation.
struct Sum {
  VecX force;
  MatX tangent;
};

Sum addElements(const FemModel& model, const Positions& positions, Tangent tangent) {
  Sum sum{VecX::Zero(model.size()), MatX::Zero(model.size(), model.size())};
  for (const FemModel::Element& element : model.elements()) {
    TetGradients x;
    std::array<int, 4> row;
    for (int a = 0; a < 4; ++a) {
      x.col(a) = positions[element.nodes[a]];
      row[a] = 3 * model.freeIndex(element.nodes[a]);
    }
    Mat3 R = Mat3::Identity();
    TetLinearisation result;
    calcTetLinearisation(element.shape, element.lame, x, tangent, R, result);
    for (int a = 0, k = 0; a < 4; ++a) {
      if (row[a] >= 0) sum.force.segment<3>(row[a]) += result.forces.col(a);
      for (int b = 0; b <= a; ++b, ++k) {
        if (row[a] < 0 || row[b] < 0) continue;
        sum.tangent.block<3, 3>(row[a], row[b]) += result.stiffness[k];
        if (a != b) sum.tangent.block<3, 3>(row[b], row[a]) += result.stiffness[k].transpose();
      }
    }
  }
  return sum;
}

double relativeDifference(const MatX& value, const MatX& reference) {
  return (value - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
}

class Assembly : public testing::TestWithParam<InstructionSet> {
 protected:
  static constexpr double kEdge = 0.01;

  /// The first `tets` of a box of cells, every element of its own stiffness, each node fixed with probability `fixed`.
  FemModel makeModel(std::size_t tets, double fixed) {
    mesh_ = makeBarMesh(Vec3(5, 3, 3) * kEdge, 5, 3, 3);
    for (Vec3& node : mesh_.nodes) node += 0.1 * kEdge * drawVector();
    mesh_.tets.resize(std::min(tets, mesh_.tets.size()));
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<Material> material;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      material.push_back({calcLame(1e5 * (1 + uniform(random_)), 0.1 + 0.35 * uniform(random_)), 1000});
    }
    std::vector<bool> is_fixed(mesh_.nodes.size());
    for (std::size_t i = 0; i < is_fixed.size(); ++i) is_fixed[i] = uniform(random_) < fixed;
    for (int node : mesh_.tets[0]) is_fixed[node] = false;
    return FemModel(mesh_, material, is_fixed, {});
  }

  Vec3 drawVector() { return Vec3(normal_(random_), normal_(random_), normal_(random_)); }

  /// The rest positions under an affine map, each node then displaced at random by `noise` edges.
  Positions deform(const Mat3& F, double noise) {
    Positions positions;
    for (const Vec3& node : mesh_.nodes) positions.push_back(F * node + noise * kEdge * drawVector());
    return positions;
  }

  Mat3 drawRotation() {
    return Eigen::Quaterniond(normal_(random_), normal_(random_), normal_(random_), normal_(random_))
        .normalized()
        .toRotationMatrix();
  }

  void expectSum(const FemModel& model, const Positions& positions, FemData& data, const char* what) {
    for (const Tangent tangent : {Tangent::kExact, Tangent::kSemidefinite}) {
      const Sum sum = addElements(model, positions, tangent);
      assemble(model, positions, tangent, data);
      EXPECT_LT(relativeDifference(data.force, sum.force), kTolerance) << what;
      EXPECT_LT(relativeDifference(data.tangent.makeDense(), sum.tangent), kTolerance) << what;
      assembleForces(model, positions, data);
      EXPECT_LT(relativeDifference(data.force, sum.force), kTolerance) << what;
    }
  }

  static constexpr double kTolerance = 1e-12;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
  TetMesh mesh_;
};

TEST_P(Assembly, IsTheSumOfTheElements) {
  const FemModel model = makeModel(1000, 0.1);
  FemData data(model, GetParam());
  for (const double noise : {0.01, 0.03, 0.1, 0.2, 0.3}) {
    expectSum(model, deform(drawRotation(), noise), data, "turned");
    expectSum(model, deform(Vec3(0.7, 0.9, 1.2).asDiagonal() * drawRotation(), noise), data, "strained");
  }
}

TEST_P(Assembly, TakesAnyNumberOfElements) {
  for (std::size_t tets = 1; tets <= 17; ++tets) {
    const FemModel model = makeModel(tets, 0.3);
    FemData data(model, GetParam());
    expectSum(model, deform(drawRotation(), 0.1), data, "few");
  }
}

TEST_P(Assembly, TakesFlatAndInvertedElements) {
  const FemModel model = makeModel(1000, 0.2);
  FemData data(model, GetParam());
  const Mat3 R = drawRotation();
  expectSum(model, deform(R * Vec3(1, 1, 0.05).asDiagonal(), 0.03), data, "nearly flat");
  expectSum(model, deform(R * Vec3(1, 0.9, 0).asDiagonal(), 0.0), data, "flat");
  expectSum(model, deform(R * Vec3(1.1, 0.9, -0.5).asDiagonal(), 0.03), data, "inverted");
  expectSum(model, deform(R, 0.6), data, "tangled");
  expectSum(model, deform(R, 0.05), data, "back again");
}

// Steps of every size, so that the search for the rotations ends at every distance from its bound.
TEST_P(Assembly, FollowsSteps) {
  const FemModel model = makeModel(1000, 0.1);
  FemData data(model, GetParam());
  Positions positions = deform(Mat3::Identity(), 0.05);
  assembleForces(model, positions, data);
  for (double size = 1e-7; size < 0.3; size *= 1.3) {
    const Mat3 step = Eigen::AngleAxisd(size, drawVector().normalized()).toRotationMatrix();
    for (Vec3& x : positions) x = step * x + 0.3 * size * kEdge * drawVector();
    assembleForces(model, positions, data);
    const Sum sum = addElements(model, positions, Tangent::kExact);
    EXPECT_LT(relativeDifference(data.force, sum.force), kTolerance) << "step " << size;
  }
}

TEST_P(Assembly, TangentIsTheDerivativeOfTheForces) {
  const FemModel model = makeModel(1000, 0.1);
  FemData data(model, GetParam());
  const Positions positions = deform(drawRotation(), 0.1);
  assemble(model, positions, Tangent::kExact, data);
  const MatX K = data.tangent.makeDense();
  for (int trial = 0; trial < 5; ++trial) {
    const double h = 1e-5 * kEdge;
    VecX direction = VecX::Zero(model.size());
    Positions plus = positions, minus = positions;
    for (int i = 0; i < model.freeCount(); ++i) {
      const Vec3 d = drawVector();
      direction.segment<3>(3 * i) = d;
      plus[model.freeNodes()[i]] += h * d;
      minus[model.freeNodes()[i]] -= h * d;
    }
    assembleForces(model, plus, data);
    const VecX force = data.force;
    assembleForces(model, minus, data);
    const VecX slope = (force - data.force) / (2 * h);
    EXPECT_LT((K * direction + slope).norm(), 1e-7 * slope.norm());
  }
}

TEST_P(Assembly, GivesTheSameEveryTime) {
  const FemModel model = makeModel(1000, 0.1);
  FemData data(model, GetParam()), again(model, GetParam());
  for (const double noise : {0.05, 0.4, 0.1}) {
    const Positions positions = deform(drawRotation(), noise);
    assemble(model, positions, Tangent::kExact, data);
    assemble(model, positions, Tangent::kExact, again);
    EXPECT_EQ(data.force, again.force);
    EXPECT_EQ(data.tangent.values(), again.tangent.values());
  }
}

INSTANTIATE_TEST_SUITE_P(EveryInstructionSet, Assembly, testing::ValuesIn(findInstructionSets()),
                         [](const auto& instance) { return nameOf(instance.param); });

}  // namespace
}  // namespace sinew
