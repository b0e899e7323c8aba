#pragma once

#include <array>
#include <vector>

#include "sinew/fem/fem_model.h"
#include "sinew/inverse/contact_finder.h"

namespace sinew {

/// Load stiffness of contacts with rigid obstacles, -force d2 gap / d x2 (N/m): how the push turns as the robot slides
/// over an obstacle that is round, or as its own face turns. For a point p = sum w_i x_i of the robot that touches a
/// shape whose distance has the second derivative C there,
///   d2 gap / dx_i dx_j = w_i w_j C - B_i (T^T C T)^-1 B_j^T,   B_i = w_i C T + n dw_i^T,
/// the second term, of an edge or a face with tangents T and gradients dw_i of the weights along them, being the
/// sliding of p to where the gap stays least. Convex obstacles make it negative: without it a Newton step turns too
/// little.
class ContactStiffness {
 public:
  explicit ContactStiffness(int max_contacts) { contacts_.reserve(static_cast<std::size_t>(max_contacts)); }

  void clear() { contacts_.clear(); }
  /// Takes over the contacts that `finder` found with nodes at `positions` [m] and their forces [N].
  void update(const ContactFinder& finder, const Eigen::Ref<const VecX>& force, const std::vector<Vec3>& positions);
  void addTo(const FemModel& fem, BlockMatrix& matrix) const;

 private:
  struct Contact {
    int count;
    std::array<int, 3> nodes;
    std::array<std::array<Mat3, 3>, 3> stiffness;
  };
  std::vector<Contact> contacts_;
};

}  // namespace sinew
