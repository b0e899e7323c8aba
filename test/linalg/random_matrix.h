#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "sinew/linalg/block_matrix.h"

namespace sinew {

inline MatX makeRandom(int rows, int columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  MatX matrix(rows, columns);
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) matrix(r, c) = normal(random);
  }
  return matrix;
}

/// `count` cliques of distinct nodes below `blocks`, some of them fixed (-1).
inline std::vector<std::vector<int>> makeRandomCliques(int blocks, int count, int size, std::mt19937& random) {
  std::vector<std::vector<int>> cliques(static_cast<std::size_t>(count));
  for (std::vector<int>& clique : cliques) {
    for (int i = 0; i < size; ++i) {
      const int node = static_cast<int>(random() % static_cast<unsigned>(blocks + 1)) - 1;
      if (std::find(clique.begin(), clique.end(), node) == clique.end()) clique.push_back(node);
    }
  }
  return cliques;
}

/// Adds G G^T of a random G over each clique, and `shift` on the diagonal: positive definite for shift > 0.
inline void addRandomGram(const std::vector<std::vector<int>>& cliques, double shift, std::mt19937& random,
                          BlockMatrix& matrix) {
  const BlockPattern& pattern = matrix.pattern();
  for (const std::vector<int>& clique : cliques) {
    const int n = 3 * static_cast<int>(clique.size());
    const MatX G = makeRandom(n, 3, random);
    for (int a = 0; a < n / 3; ++a) {
      for (int b = 0; b < n / 3; ++b) {
        if (clique[b] < 0 || clique[a] < clique[b]) continue;
        matrix.add(pattern.slot(clique[a], clique[b]), G.middleRows<3>(3 * a) * G.middleRows<3>(3 * b).transpose());
      }
    }
  }
  for (int i = 0; i < pattern.blocks(); ++i) matrix.add(pattern.slot(i, i), shift * Mat3::Identity());
}

}  // namespace sinew
