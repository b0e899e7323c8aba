#include "sinew/solver/search_budget.h"

namespace sinew {

using Clock = std::chrono::steady_clock;

void SearchBudget::start(const QpccBudget& budget) {
  budget_ = budget;
  pieces_ = nodes_ = 0;
  deadline_passed_ = false;
}

bool SearchBudget::due() {
  if (!deadline_passed_ && budget_.deadline != Clock::time_point::max())
    deadline_passed_ = Clock::now() >= budget_.deadline;
  return deadline_passed_;
}

}  // namespace sinew
