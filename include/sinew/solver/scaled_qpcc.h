#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/qpcc_problem.h"

namespace sinew {

/// A QPCC in units that make its entries of order one, duplicate contacts merged:
///   x = magnitude * unknown_unit * x',   z = magnitude * contact_unit * z',   g = magnitude / contact_unit * g',
///   row = magnitude / row_scale * row',  E x + e = magnitude / effector_scale * (...)'.
/// Contact units make the diagonal of C_c one. All factors are powers of two, so that scaling rounds nothing.
/// A contact without compliance stays open: its gap is one more limited row where x moves it, and is left alone where
/// nothing does.
///
/// `table` holds all linear maps: its rows are the contacts, the limited rows, the effectors; its columns the contacts,
/// the unknowns, the constants.
struct ScaledQpcc {
  explicit ScaledQpcc(const QpccSizes& capacity);

  /// Of two contacts with the same normal only the nearer one stays: the other never presses. `problem` must be finite.
  /// Never allocates.
  void update(const QpccProblem& problem);

  int limitedRows() const { return size.contacts + size.rows; }
  int tableRows() const { return limitedRows() + size.effectors; }
  int tableColumns() const { return size.contacts + size.unknowns + 1; }
  int rigidRows() const { return static_cast<int>(rigid_.size()); }  ///< last of the rows
  int at(int k) const { return contact[static_cast<std::size_t>(k)]; }
  double objectiveUnit() const { return (magnitude / effector_scale) * (magnitude / effector_scale); }

  QpccSizes size;  ///< `contacts` counts those that stay, `rows` the rigid contacts too
  MatX table;
  VecX row_lower, row_upper;  ///< limits of the table's leading `limitedRows()`: zero to infinity for contacts
  VecX x_lower, x_upper, soft_lower, soft_upper;
  VecX soft_range;  ///< unit in which a soft limit of each unknown gives way: the distance between both, if finite
  MatX Q;
  VecX q;

  std::vector<int> contact;  ///< index in the problem of each contact that stays
  VecX contact_unit, unknown_unit, row_scale;
  double effector_scale = 1, magnitude = 1;

 private:
  void updateContacts(const QpccProblem& problem);
  bool isCovered(const QpccProblem& problem, int i) const;
  void updateContactUnits(const QpccProblem& problem);
  void updateEffectorScale(const QpccProblem& problem);
  void updateUnknownUnits(const QpccProblem& problem);
  void updateRowScales(const QpccProblem& problem);
  void updateMagnitude(const QpccProblem& problem);
  void fillTable(const QpccProblem& problem);
  void fillLimits(const QpccProblem& problem);

  std::vector<int> rigid_;    ///< contacts of the problem that became the last rows
  std::vector<char> merged_;  ///< by contact of the problem
  VecX motion_;               ///< largest that a unit of each unknown causes in the scaled contacts
  VecX diagonal_;             ///< of C_c
};

}  // namespace sinew
