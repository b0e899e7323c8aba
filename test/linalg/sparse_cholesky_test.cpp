#include "sinew/linalg/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>
#include <numeric>

#include "linalg/random_matrix.h"
#include "sinew/linalg/cholmod_cholesky.h"
#include "sinew/linalg/elimination.h"
#include "sinew/linalg/supernodal_cholesky.h"

namespace sinew {
namespace {

constexpr int kMaxRows = 70;

using Cliques = std::vector<std::vector<int>>;

struct Layout {
  std::string name;
  int blocks;
  Cliques cliques;
};

Layout makeSparse() {
  std::mt19937 random(1);
  return {"Sparse", 80, makeRandomCliques(80, 90, 4, random)};
}

/// Two large groups that share most of their nodes.
Layout makeCrowded() {
  std::vector<int> first(230), second(230);
  std::iota(first.begin(), first.end(), 0);
  std::iota(second.begin(), second.end(), 40);
  return {"Crowded", 270, {first, second}};
}

/// A slender body, each node coupled to those within `reach`.
Layout makeChain() {
  Cliques cliques;
  for (int i = 0; i + 7 < 150; ++i) {
    cliques.emplace_back(8);
    std::iota(cliques.back().begin(), cliques.back().end(), i);
  }
  return {"Chain", 150, cliques};
}

/// Parts that nothing couples, one of them a single node.
Layout makeApart() {
  return {"Apart", 12, {{0, 3, 5}, {1, 4}, {5, 7}, {8, 9, 10, 11}}};
}

struct Method {
  std::string name;
  std::function<std::unique_ptr<SparseCholesky>(const FactorPattern&)> make;
};

std::vector<Method> makeMethods() {
  std::vector<Method> methods = {
      {"cholmod", [](const FactorPattern& pattern) { return std::make_unique<CholmodCholesky>(pattern, kMaxRows); }}};
  for (const InstructionSet set : findInstructionSets()) {
    for (const int threads : {1, 2, 5}) {
      methods.push_back(
          {std::string(nameOf(set)) + "_" + std::to_string(threads), [set, threads](const FactorPattern& pattern) {
             return std::make_unique<SupernodalCholesky>(pattern, kMaxRows, threads, set);
           }});
    }
  }
  return methods;
}

/// The layout in its order of elimination.
struct Ordered {
  Cliques cliques;
  FactorPattern pattern;

  static Ordered make(const Layout& layout) {
    const Elimination elimination = makeElimination(BlockPattern(layout.blocks, layout.cliques));
    std::vector<int> place(static_cast<std::size_t>(layout.blocks));
    for (int k = 0; k < layout.blocks; ++k) place[elimination.order[k]] = k;
    Cliques cliques = layout.cliques;
    for (std::vector<int>& clique : cliques) {
      for (int& block : clique) block = block < 0 ? -1 : place[block];
    }
    return {cliques, FactorPattern(BlockPattern(layout.blocks, cliques), elimination.panel_start)};
  }
};

class SparseCholeskyTest : public testing::TestWithParam<std::tuple<Layout, Method>> {
 protected:
  std::mt19937 random{2};
  Ordered ordered = Ordered::make(std::get<0>(GetParam()));
  BlockMatrix matrix{ordered.pattern.matrix()};
  std::unique_ptr<SparseCholesky> cholesky = std::get<1>(GetParam()).make(ordered.pattern);
  int size = ordered.pattern.size();
  MatX dense;

  void makeMatrix(double shift) {
    matrix.setZero();
    addRandomGram(ordered.cliques, shift, random, matrix);
    dense = matrix.makeDense();
  }

  void expectSolves() {
    const VecX right = makeRandom(size, 1, random);
    VecX x = right;
    cholesky->solve(x);
    EXPECT_LT((x - dense.llt().solve(right)).norm(), 1e-9 * x.norm());
    EXPECT_LT((dense * x - right).norm(), 1e-10 * right.norm());
  }

  /// Rows with entries in up to `most` blocks, as cables, contacts and effectors have.
  BlockRows makeRows(int count, int most) {
    BlockRows rows(count, count * most);
    for (int i = 0; i < count; ++i) {
      rows.beginRow();
      const int entries = 1 + static_cast<int>(random() % static_cast<unsigned>(most));
      for (int k = 0; k < entries; ++k) {
        rows.add(static_cast<int>(random() % static_cast<unsigned>(size / 3)), Vec3(makeRandom(3, 1, random)));
      }
    }
    return rows;
  }

  MatX makeDenseRows(const BlockRows& rows) const {
    MatX H = MatX::Zero(rows.rows(), size);
    for (int i = 0; i < rows.rows(); ++i) {
      for (const auto* entry = rows.begin(i); entry != rows.end(i); ++entry) {
        H.block<1, 3>(i, 3 * entry->block) += entry->derivative.transpose();
      }
    }
    return H;
  }

  void expectCondenses(const BlockRows& rows) {
    const MatX H = makeDenseRows(rows);
    const VecX load = makeRandom(size, 1, random);
    const int n = rows.rows();
    MatX compliance(n, n);
    VecX motion(n), x(size);
    cholesky->condense(rows, load, compliance, motion);
    const Eigen::LLT<MatX> factor(dense);
    const MatX W = H * factor.solve(H.transpose());
    EXPECT_LE((compliance - W).norm(), 1e-11 * W.norm());
    EXPECT_LE((compliance - compliance.transpose()).norm(), 1e-14 * W.norm());
    const VecX free = factor.solve(load);
    EXPECT_LE((motion - H * free).norm(), 1e-11 * H.norm() * free.norm());
    const VecX force = makeRandom(n, 1, random);
    cholesky->calcMotion(force, x);
    const VecX expected = free + factor.solve(H.transpose() * force);
    EXPECT_LT((x - expected).norm(), 1e-11 * expected.norm());
  }
};

TEST_P(SparseCholeskyTest, SolvesAsTheDenseFactorDoes) {
  EXPECT_EQ(cholesky->size(), size);
  makeMatrix(1);
  ASSERT_TRUE(cholesky->factorise(matrix));
  expectSolves();
  expectSolves();
}

TEST_P(SparseCholeskyTest, CondensesAsTheDenseFactorDoes) {
  makeMatrix(1);
  ASSERT_TRUE(cholesky->factorise(matrix));
  for (const int count : {0, 1, 2, 7, 8, 9, 23, 64, kMaxRows}) {
    expectCondenses(makeRows(count, 3));
    expectCondenses(makeRows(count, 30));
  }
}

TEST_P(SparseCholeskyTest, FactorisesAgainWithOtherValues) {
  for (const double shift : {1.0, 100.0, 0.5}) {
    makeMatrix(shift);
    ASSERT_TRUE(cholesky->factorise(matrix));
    expectSolves();
    expectCondenses(makeRows(12, 5));
  }
}

// A negative eigenvalue anywhere, and recovery in the cycle after.
TEST_P(SparseCholeskyTest, RefusesAnIndefiniteMatrixAndRecovers) {
  const BlockPattern& pattern = ordered.pattern.matrix();
  for (const int block : {0, pattern.blocks() / 2, pattern.blocks() - 1}) {
    makeMatrix(1);
    matrix.add(pattern.slot(block, block), -1e4 * Mat3::Identity());
    EXPECT_FALSE(cholesky->factorise(matrix));
    makeMatrix(1);
    ASSERT_TRUE(cholesky->factorise(matrix));
    expectSolves();
  }
}

TEST_P(SparseCholeskyTest, RefusesAMatrixOfNothing) {
  matrix.setZero();
  EXPECT_FALSE(cholesky->factorise(matrix));
}

INSTANTIATE_TEST_SUITE_P(Layouts, SparseCholeskyTest,
                         testing::Combine(testing::Values(makeSparse(), makeCrowded(), makeChain(), makeApart()),
                                          testing::ValuesIn(makeMethods())),
                         [](const auto& layout) {
                           return std::get<0>(layout.param).name + "_" + std::get<1>(layout.param).name;
                         });

}  // namespace
}  // namespace sinew
