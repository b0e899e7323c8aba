#pragma once

#include <Eigen/SVD>

#include "sinew/fem/fem_model.h"

namespace sinew {

/// Elastic energy [J]: V (mu |F - R|^2 + lambda / 2 tr(R^T F - I)^2) summed over the elements, in the singular values
/// of F. Holds where no element is inverted.
inline double calcElasticEnergy(const FemModel& model, const std::vector<Vec3>& positions) {
  double energy = 0;
  for (const FemModel::Element& element : model.elements()) {
    TetGradients x;
    for (int a = 0; a < 4; ++a) x.col(a) = positions[element.nodes[a]];
    const Mat3 F = x * element.shape.gradients.transpose();
    const Vec3 stretch = Vec3(Eigen::JacobiSVD<Mat3>(F).singularValues()) - Vec3::Ones();
    const double trace = stretch.sum();
    energy +=
        element.shape.volume * (element.lame.mu * stretch.squaredNorm() + element.lame.lambda / 2 * trace * trace);
  }
  return energy;
}

/// Forces that the elements put on every mesh node, fixed ones too [N].
inline std::vector<Vec3> calcElasticForces(const FemModel& model, const std::vector<Vec3>& positions) {
  std::vector<Vec3> forces(positions.size(), Vec3::Zero());
  for (const FemModel::Element& element : model.elements()) {
    TetGradients x, force;
    for (int a = 0; a < 4; ++a) x.col(a) = positions[element.nodes[a]];
    Mat3 R = Mat3::Identity();
    calcTetForces(element.shape, element.lame, x, R, force);
    for (int a = 0; a < 4; ++a) forces[element.nodes[a]] += force.col(a);
  }
  return forces;
}

}  // namespace sinew
