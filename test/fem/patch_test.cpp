#include <random>

#include "check_line.h"
#include "mesh/bar_mesh.h"
#include "sinew/fem/fem_model.h"
#include "sinew/linalg/supernodal_cholesky.h"

namespace sinew {
namespace {

const Vec3 kSize(0.3, 0.2, 0.1);

bool onBoundary(const Vec3& x) {
  return (x.array() < 1e-9).any() || ((kSize - x).array() < 1e-9).any();
}

// A box whose inner nodes are moved at random, so that no two elements are alike.
TetMesh makeIrregularBox(unsigned seed) {
  TetMesh mesh = makeBarMesh(kSize, 6, 4, 3);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.008, 0.008);
  for (Vec3& node : mesh.nodes) {
    if (!onBoundary(node)) node += Vec3(shift(random), shift(random), shift(random));
  }
  return mesh;
}

FemModel makeModel(const TetMesh& mesh, bool hold_boundary) {
  std::vector<bool> fixed;
  for (const Vec3& node : mesh.nodes) fixed.push_back(hold_boundary && onBoundary(node));
  return FemModel(mesh, std::vector<Material>(mesh.tets.size(), Material{calcLame(2e5, 0.4), 1000}), fixed, {});
}

// With the boundary on an affine map, the inner nodes' equilibrium is on the same map: any element must represent a
// uniform strain exactly.
double affineError(const Mat3& F, unsigned seed) {
  const TetMesh mesh = makeIrregularBox(seed);
  const FemModel model = makeModel(mesh, true);
  FemData data(model);
  SupernodalCholesky cholesky(model.factor(), 0);
  std::vector<Vec3> positions = mesh.nodes;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (onBoundary(mesh.nodes[i])) positions[i] = F * mesh.nodes[i];
  }
  for (int k = 0; k < 60; ++k) {
    assemble(model, positions, k < 30 ? Tangent::kSemidefinite : Tangent::kExact, data);
    VecX motion = data.force;
    EXPECT_TRUE(cholesky.factorise(data.tangent));
    cholesky.solve(motion);
    for (int i = 0; i < model.freeCount(); ++i) positions[model.freeNodes()[i]] += motion.segment<3>(3 * i);
  }
  double worst = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    worst = std::max(worst, (positions[i] - F * mesh.nodes[i]).norm() / kSize.norm());
  }
  return worst;
}

TEST(PatchTest, UniformStrainIsReproduced) {
  Mat3 small = Mat3::Identity(), large;
  small(0, 1) = 1e-3;
  small(2, 2) = 1.002;
  large << 1.2, 0.1, 0, -0.15, 0.95, 0.05, 0.02, 0, 1.1;
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  checkFigure("patch_test.small_strain", affineError(small, 1), "<=", 1e-10, "1");
  checkFigure("patch_test.large_strain", affineError(large, 2), "<=", 1e-10, "1");
  checkFigure("patch_test.turned", affineError(turn * small, 3), "<=", 1e-10, "1");
}

TEST(RigidMotion, GivesNoForce) {
  const TetMesh mesh = makeIrregularBox(4);
  const FemModel model = makeModel(mesh, false);
  FemData data(model);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 axis = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Mat3 R = Eigen::AngleAxisd(3.1 * std::abs(normal(random)), axis).toRotationMatrix();
    const Vec3 shift(normal(random), normal(random), normal(random));
    std::vector<Vec3> moved, stretched;
    for (const Vec3& node : mesh.nodes) {
      moved.push_back(R * node + shift);
      stretched.push_back(1.01 * (R * node) + shift);
    }
    assembleForces(model, stretched, data);
    const double reference = data.force.norm();
    assembleForces(model, moved, data);
    worst = std::max(worst, data.force.norm() / reference);
  }
  checkFigure("rigid_motion.force", worst, "<=", 1e-9, "1");
}

}  // namespace
}  // namespace sinew
