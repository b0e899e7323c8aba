#include "sinew/inverse/contact_piece.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace sinew {
namespace {

constexpr double kContactCompliance = 1e-10;  // of a contact's own, where contacts depend on each other
constexpr double kRounding = 5e-10;           // m, a pull that moves its gap by less is none

}  // namespace

ContactPiece::ContactPiece(int actuators, int effector_rows, int max_contacts)
    : actuators_(actuators),
      reduced_(actuators + effector_rows + max_contacts, actuators + 1),
      factor_(max_contacts, max_contacts),
      answer_(max_contacts, actuators + 1),
      coupling_(actuators + effector_rows + max_contacts, max_contacts),
      scale_(max_contacts),
      own_(max_contacts),
      shift_(max_contacts) {
  pressing_.reserve(static_cast<std::size_t>(max_contacts));
  presses_.reserve(static_cast<std::size_t>(max_contacts));
}

bool ContactPiece::reduce(const CondensedRobot& robot, const std::vector<char>& pressing) {
  const auto W = robot.compliance();
  const int n = actuators_, first = robot.firstContact();
  rows_ = robot.rows();
  contacts_ = robot.contacts();
  presses_.assign(pressing.begin(), pressing.begin() + contacts_);
  pressing_.clear();
  for (int i = 0; i < contacts_; ++i) {
    if (presses_[i]) pressing_.push_back(i);
  }
  pressing_count_ = static_cast<int>(pressing_.size());

  reduced_.topLeftCorner(rows_, n) = W.leftCols(n);
  reduced_.col(n).head(rows_) = robot.freeMotion();
  reduced_.col(n).head(n) += robot.displacement();
  reduced_.col(n).segment(first, contacts_) += robot.gap();
  own_.head(contacts_) = W.diagonal().tail(contacts_);
  if (pressing_count_ == 0) return true;

  const int p = pressing_count_;
  for (int i = 0; i < p; ++i) {
    const int row = first + pressing_[i];
    if (!(W(row, row) > 0)) return false;
    scale_[i] = 1 / std::sqrt(W(row, row));
    answer_.row(i) = scale_[i] * reduced_.row(row);
    coupling_.col(i).head(rows_) = W.col(row) * scale_[i];
    for (int j = 0; j <= i; ++j) factor_(i, j) = W(row, first + pressing_[j]) * scale_[i] * scale_[j];
    factor_(i, i) += kContactCompliance;
  }
  Eigen::Ref<MatX> block = factor_.topLeftCorner(p, p);
  const Eigen::LLT<Eigen::Ref<MatX>> cholesky(block);
  if (cholesky.info() != Eigen::Success) return false;
  auto answer = answer_.topRows(p);
  cholesky.matrixL().solveInPlace(answer);
  cholesky.matrixU().solveInPlace(answer);
  reduced_.topRows(rows_).noalias() -= coupling_.topLeftCorner(rows_, p) * answer;
  for (int i = 0; i < p; ++i) reduced_.row(first + pressing_[i]) = -scale_[i] * answer.row(i);
  return true;
}

void ContactPiece::calcResponse(const VecX& shift, VecX& response) {
  const int p = pressing_count_;
  for (int i = 0; i < p; ++i) shift_[i] = scale_[i] * shift[pressing_[i]];
  auto answer = shift_.head(p);
  const auto lower = factor_.topLeftCorner(p, p).triangularView<Eigen::Lower>();
  lower.solveInPlace(answer);
  lower.transpose().solveInPlace(answer);
  response.head(firstContact()).noalias() = -coupling_.topLeftCorner(firstContact(), p) * answer;
}

void ContactPiece::calcContacts(const VecX& effort_change, VecX& force, VecX& gap) const {
  const int first = firstContact();
  for (int i = 0; i < contacts_; ++i) {
    const double side = reduced_.row(first + i).head(actuators_).dot(effort_change) + reduced_(first + i, actuators_);
    const bool rounded = side < 0 && -side * own_[i] < kRounding;
    force[i] = presses_[i] && !rounded ? side : 0.0;
    gap[i] = presses_[i] ? 0.0 : side;
  }
}

}  // namespace sinew
