#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/condensed_robot.h"

namespace sinew {

/// A condensed robot with some of its contacts pressing and the others lifted off (thesis 4.4.2). The gaps of the
/// pressing ones stay 0, which eliminates their forces: every row of the robot becomes affine in the changes of effort
/// alone,
///   value + W d,   W = W_ra - W_rp W_pp^-1 W_pa,   value = v_r - W_rp W_pp^-1 v_p,
/// and so do the forces of the pressing contacts, which take the place of their rows. No allocation after construction.
class ContactPiece {
 public:
  ContactPiece(int actuators, int effector_rows, int max_contacts);

  /// `pressing`: one entry per contact. False when W_pp is not positive definite.
  bool reduce(const CondensedRobot& robot, const std::vector<char>& pressing);

  /// Rows in the order of the robot: displacements and effectors' motion [m], then per contact its gap [m] or, where it
  /// presses, its force [N].
  auto W() const { return reduced_.topLeftCorner(rows_, actuators_); }
  auto value() const { return reduced_.col(actuators_).head(rows_); }
  int contacts() const { return contacts_; }
  int firstContact() const { return rows_ - contacts_; }

  /// What `shift` of the gaps [m] has moved the rows before the contacts by [m].
  void calcResponse(const VecX& shift, VecX& response);

  /// Signorini's two sides for changes of effort [N]: one of them is exactly 0 for every contact.
  void calcContacts(const VecX& effort_change, VecX& force, VecX& gap) const;

 private:
  int actuators_, rows_ = 0, contacts_ = 0, pressing_count_ = 0;
  MatX reduced_;               // [W value]
  MatX factor_;                // of W_pp, scaled to a unit diagonal
  MatX answer_;                // W_pp^-1 [W_pa v_p]
  MatX coupling_;              // W_rp
  VecX scale_, own_, shift_;   // own_: each contact's W_ii [m/N]
  std::vector<int> pressing_;  // contacts
  std::vector<char> presses_;
};

}  // namespace sinew
