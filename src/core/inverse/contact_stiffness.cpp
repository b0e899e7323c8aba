#include "sinew/inverse/contact_stiffness.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "sinew/contact/feature_pair.h"

namespace sinew {
namespace {

constexpr double kLeastRadius = 1e-4;   // m, as which a corner counts
constexpr double kFlat = 0.1;           // 1/m, curvature below which nothing slides
constexpr double kNormalOfCap = 0.999;  // cosine to the axis of a cylinder, above which its flat end is touched

/// Second derivative of the distance to a shape at `point` with the given normal.
Mat3 calcCurvature(const ObstacleShape& shape, const Pose& pose, PairKind kind, const Vec3& point, const Vec3& normal) {
  const Mat3 tangential = Mat3::Identity() - normal * normal.transpose();
  if (kind == PairKind::kFaceVertex) return tangential / kLeastRadius;
  if (shape.kind() == ObstacleShape::Kind::kSphere) {
    return tangential / std::max(kLeastRadius, (point - pose.translation()).norm());
  }
  if (shape.kind() != ObstacleShape::Kind::kCylinder) return Mat3::Zero();
  const Vec3 axis = pose.linear().col(2);
  if (std::abs(normal.dot(axis)) > kNormalOfCap) return Mat3::Zero();
  const Vec3 from = point - pose.translation();
  const double radius = std::max(kLeastRadius, (from - axis * axis.dot(from)).norm());
  return (tangential - axis * axis.transpose()) / radius;
}

/// Tangents of an edge or a face, and along them the gradients of the weights of its corners.
struct Feature {
  int tangents = 0;
  Eigen::Matrix<double, 3, 2> T = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix<double, 3, 2> dw = Eigen::Matrix<double, 3, 2>::Zero();  // by corner

  Feature(const std::array<Vec3, 3>& corner, int count) : tangents(count - 1) {
    if (count == 2) {
      const Vec3 along = corner[1] - corner[0];
      const double length = along.norm();
      T.col(0) = along / length;
      dw(0, 0) = -1 / length;
      dw(1, 0) = 1 / length;
    } else if (count == 3) {
      const Vec3 area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
      T.col(0) = (corner[1] - corner[0]).normalized();
      T.col(1) = area.normalized().cross(Vec3(T.col(0)));
      for (int i = 0; i < 3; ++i) {
        const Vec3 opposite = corner[(i + 2) % 3] - corner[(i + 1) % 3];
        dw.row(i) = (area.normalized().cross(opposite) / area.norm()).transpose() * T;
      }
    }
  }
};

/// (T^T C T)^-1, without the directions in which nothing is curved.
Eigen::Matrix2d calcSliding(const Feature& feature, const Mat3& C) {
  const Eigen::Matrix2d curved = feature.T.transpose() * C * feature.T;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(curved);
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d direction = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()[k] > kFlat) inverse += direction * direction.transpose() / eigen.eigenvalues()[k];
  }
  return inverse;
}

}  // namespace

void ContactStiffness::update(const ContactFinder& finder, const Eigen::Ref<const VecX>& force,
                              const std::vector<Vec3>& positions) {
  clear();
  const ContactList& list = finder.list();
  for (int c = 0; c < list.size(); ++c) {
    const ContactRow& row = list.row(c);
    if (row.obstacle < 0 || row.entries > 3 || !(force[c] > 0)) continue;
    const ContactFinder::Placed part = finder.part(row.obstacle);
    const Mat3 C = calcCurvature(*part.shape, part.pose, kindOf(row.key), row.point, row.normal);
    if (C.isZero(0)) continue;
    Contact contact;
    contact.count = row.entries;
    std::array<Vec3, 3> corner;
    Vec3 weight = Vec3::Zero();
    for (int i = 0; i < row.entries; ++i) {
      contact.nodes[i] = list.entries(c)[i].node;
      corner[i] = positions[contact.nodes[i]];
      weight[i] = row.normal.dot(list.entries(c)[i].gradient);
    }
    const Feature feature(corner, row.entries);
    const Eigen::Matrix2d sliding = calcSliding(feature, C);
    std::array<Eigen::Matrix<double, 3, 2>, 3> B;
    for (int i = 0; i < row.entries; ++i) B[i] = weight[i] * C * feature.T + row.normal * feature.dw.row(i);
    for (int i = 0; i < row.entries; ++i) {
      for (int j = 0; j < row.entries; ++j) {
        contact.stiffness[i][j] = -force[c] * (weight[i] * weight[j] * C - B[i] * sliding * B[j].transpose());
      }
    }
    contacts_.push_back(contact);
  }
}

void ContactStiffness::addTo(const FemModel& fem, BlockMatrix& matrix) const {
  for (const Contact& contact : contacts_) {
    for (int i = 0; i < contact.count; ++i) {
      const int row = fem.freeIndex(contact.nodes[i]);
      for (int j = 0; j < contact.count; ++j) {
        const int column = fem.freeIndex(contact.nodes[j]);
        if (column < 0 || row < column) continue;
        matrix.add(fem.pattern().slot(row, column), contact.stiffness[i][j]);
      }
    }
  }
}

}  // namespace sinew
