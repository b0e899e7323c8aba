#include "sinew/solver/qpcc_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "qpcc_enumeration.h"
#include "random_qpcc.h"
#include "sinew/solver/contact_lcp.h"
#include "sinew/solver/piece_qp.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Solves the one piece that holds an actuation, and never goes elsewhere.
class PlainGuide : public TreeGuide {
 public:
  explicit PlainGuide(const ScaledQpcc& problem, const QpccSizes& size) : tableau_(size), piece_(size), answer_(size) {
    tableau_.reset(problem);
    piece_.attach(problem);
  }

  double bestObjective() const override { return best_; }
  void descendFrom(const Eigen::Ref<const VecX>& x) override {
    if (blind || !solveContactLcp(x, tableau_) || !piece_.solve(tableau_.map(), answer_)) return;
    best_ = std::min(best_, answer_.merit.objective);
  }
  bool isOpen(int contact) const override { return contact % 3 > 0; }  // whatever it is, the answer is the same
  void widen() override { ++widenings; }
  void restart() override { ++restarts; }
  bool presses(const Eigen::Ref<const VecX>&, int contact) override { return contact % 2 == 0; }

  bool blind = false;
  int restarts = 0, widenings = 0;

 private:
  ComplementarityTableau tableau_;
  PieceQp piece_;
  PieceAnswer answer_;
  double best_ = kInfinity;
};

TEST(QpccTree, findsAndProvesTheOptimumByItself) {
  std::mt19937 random(1);
  int proved = 0;
  int infeasible = 0;
  constexpr int kProblems = 300;
  for (int k = 0; k < kProblems; ++k) {
    const QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 3, 6, random);
    const double optimum = FullQpcc(problem).enumerate();
    ScaledQpcc scaled(problem.size);
    scaled.update(problem);
    PlainGuide guide(scaled, problem.size);
    SearchBudget budget;
    budget.start(QpccBudget());
    QpccTree tree(problem.size);
    if (tree.explore(scaled, budget, guide) != QpccTree::Outcome::kExhausted) continue;
    ++proved;
    const double found = guide.bestObjective() * scaled.objectiveUnit();
    if (!std::isfinite(optimum)) {
      ++infeasible;
      EXPECT_FALSE(std::isfinite(found));
      continue;
    }
    EXPECT_NEAR(found, optimum, 1e-5 * (optimum + 1e-3 * 0.5 * problem.e.squaredNorm())) << k;
  }
  EXPECT_GT(proved, 0.95 * kProblems);
  EXPECT_LT(infeasible, 0.2 * kProblems);
}

TEST(QpccTree, claimsNothingThatItsGuideDidNotFind) {
  std::mt19937 random(2);
  for (int k = 0; k < 50; ++k) {
    const QpccProblem problem = makeQpcc(QpccKind::kBar, 3, 6, random);
    ScaledQpcc scaled(problem.size);
    scaled.update(problem);
    PlainGuide guide(scaled, problem.size);
    guide.blind = true;
    SearchBudget budget;
    budget.start(QpccBudget());
    QpccTree tree(problem.size);
    EXPECT_EQ(tree.explore(scaled, budget, guide), QpccTree::Outcome::kInterrupted) << k;
  }
}

TEST(QpccTree, stopsWithItsBudget) {
  std::mt19937 random(3);
  const QpccProblem problem = makeQpcc(QpccKind::kRandom, 8, 40, random);
  ScaledQpcc scaled(problem.size);
  scaled.update(problem);
  PlainGuide guide(scaled, problem.size);
  QpccBudget allowed;
  allowed.max_nodes = 5;
  SearchBudget budget;
  budget.start(allowed);
  QpccTree tree(problem.size);
  EXPECT_EQ(tree.explore(scaled, budget, guide), QpccTree::Outcome::kInterrupted);
  EXPECT_EQ(budget.nodes(), 5);
}

}  // namespace
}  // namespace sinew
