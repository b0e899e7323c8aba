#include "sinew/linalg/elimination.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sinew/linalg/factor_pattern.h"
#include "sinew/linalg/panel_shares.h"

namespace sinew {
namespace {

constexpr int kPanelBlocks = 9;  // 27 columns: three register tiles

/// The tree of supernodes while it is cut and merged.
class SupernodeTree {
 public:
  SupernodeTree(const BlockPattern& pattern, const BlockOrder& order);

  void merge();
  Elimination makeElimination() const;

 private:
  struct Supernode {
    std::vector<int> blocks;  // in the order of elimination
    int below = 0;            // blocks of rows under the square
    int parent = -1;
    std::vector<int> children;
    double cost = 0;
  };

  static std::vector<int> calcParents(const BlockGraph& graph, const BlockOrder& order);
  static BlockOrder calcPostorder(const std::vector<int>& parent);
  static std::vector<std::vector<int>> calcRows(const BlockGraph& graph, const BlockOrder& order,
                                                const std::vector<int>& parent);
  void gather(const BlockOrder& order, const std::vector<int>& parent, const std::vector<std::vector<int>>& rows);
  double calcSaving(int child, int parent) const;
  void absorb(int child, int parent);

  std::vector<Supernode> supernodes_;  // children before their parents; merged ones are empty
};

/// Liu's elimination tree: parent[k] is the first column below k in the factor.
std::vector<int> SupernodeTree::calcParents(const BlockGraph& graph, const BlockOrder& order) {
  const std::size_t blocks = order.size();
  std::vector<int> place(blocks), parent(blocks, -1), ancestor(blocks, -1);
  for (std::size_t k = 0; k < blocks; ++k) place[order[k]] = static_cast<int>(k);
  for (int k = 0; k < static_cast<int>(blocks); ++k) {
    const int block = order[k];
    for (int e = graph.start[block]; e < graph.start[block + 1]; ++e) {
      int i = place[graph.neighbour[e]];
      while (i >= 0 && i < k) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next < 0) parent[i] = k;
        i = next;
      }
    }
  }
  return parent;
}

BlockOrder SupernodeTree::calcPostorder(const std::vector<int>& parent) {
  const int count = static_cast<int>(parent.size());
  std::vector<std::vector<int>> children(parent.size());
  std::vector<int> open;
  for (int k = count - 1; k >= 0; --k) {
    if (parent[k] < 0) {
      open.push_back(k);
    } else {
      children[parent[k]].push_back(k);
    }
  }
  BlockOrder post;
  while (!open.empty()) {  // parents before their children, then the other way round
    const int k = open.back();
    open.pop_back();
    post.push_back(k);
    open.insert(open.end(), children[k].rbegin(), children[k].rend());
  }
  std::reverse(post.begin(), post.end());
  return post;
}

/// Rows of every column of the factor under its diagonal: its own entries and what its children leave.
std::vector<std::vector<int>> SupernodeTree::calcRows(const BlockGraph& graph, const BlockOrder& order,
                                                      const std::vector<int>& parent) {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  std::vector<std::vector<int>> rows(order.size());
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    for (int e = graph.start[order[k]]; e < graph.start[order[k] + 1]; ++e) {
      const int row = place[graph.neighbour[e]];
      if (row > k) rows[k].push_back(row);
    }
    std::sort(rows[k].begin(), rows[k].end());
  }
  std::vector<int> merged;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (parent[k] < 0) continue;
    std::vector<int>& up = rows[parent[k]];
    merged.clear();
    std::set_union(up.begin(), up.end(), rows[k].begin() + 1, rows[k].end(), std::back_inserter(merged));
    up = merged;
  }
  return rows;
}

SupernodeTree::SupernodeTree(const BlockPattern& pattern, const BlockOrder& given) {
  const BlockGraph graph(pattern);
  BlockOrder order;
  order.reserve(given.size());
  for (const int k : calcPostorder(calcParents(graph, given))) order.push_back(given[k]);
  const std::vector<int> parent = calcParents(graph, order);
  gather(order, parent, calcRows(graph, order, parent));
}

/// Consecutive columns with the same rows make a supernode.
void SupernodeTree::gather(const BlockOrder& order, const std::vector<int>& parent,
                           const std::vector<std::vector<int>>& rows) {
  std::vector<int> supernode(order.size(), -1);
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    const bool continues = k > 0 && parent[k - 1] == k && rows[k - 1].size() == rows[k].size() + 1;
    if (!continues) supernodes_.emplace_back();
    supernode[k] = static_cast<int>(supernodes_.size()) - 1;
    supernodes_.back().blocks.push_back(order[k]);
    supernodes_.back().below = static_cast<int>(rows[k].size());
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (parent[k] < 0 || supernode[parent[k]] == supernode[k]) continue;
    supernodes_[supernode[k]].parent = supernode[parent[k]];
    supernodes_[supernode[parent[k]]].children.push_back(supernode[k]);
  }
  for (Supernode& node : supernodes_) node.cost = calcPanelCost(static_cast<int>(node.blocks.size()), node.below);
}

double SupernodeTree::calcSaving(int child, int parent) const {
  const Supernode &c = supernodes_[child], &p = supernodes_[parent];
  return c.cost + p.cost - calcPanelCost(static_cast<int>(c.blocks.size() + p.blocks.size()), p.below);
}

void SupernodeTree::absorb(int child, int parent) {
  Supernode &c = supernodes_[child], &p = supernodes_[parent];
  p.blocks.insert(p.blocks.begin(), c.blocks.begin(), c.blocks.end());
  p.children.erase(std::find(p.children.begin(), p.children.end(), child));
  p.children.insert(p.children.end(), c.children.begin(), c.children.end());
  for (const int grandchild : c.children) supernodes_[grandchild].parent = parent;
  p.cost = calcPanelCost(static_cast<int>(p.blocks.size()), p.below);
  c = Supernode();
}

void SupernodeTree::merge() {
  for (int parent = 0; parent < static_cast<int>(supernodes_.size()); ++parent) {
    while (true) {
      int best = -1;
      double saving = 0;
      for (const int child : supernodes_[parent].children) {
        const double now = calcSaving(child, parent);
        if (now > saving) {
          best = child;
          saving = now;
        }
      }
      if (best < 0) break;
      absorb(best, parent);
    }
  }
}

Elimination SupernodeTree::makeElimination() const {
  std::vector<int> parent;
  for (const Supernode& node : supernodes_) parent.push_back(node.parent);
  Elimination result;
  for (const int s : calcPostorder(parent)) {
    const Supernode& node = supernodes_[s];
    const int own = static_cast<int>(node.blocks.size());
    const int panels = (own + kPanelBlocks - 1) / kPanelBlocks;
    for (int panel = 0; panel < panels; ++panel) {
      const int first = own * panel / panels, end = own * (panel + 1) / panels;
      result.panel_start.push_back(static_cast<int>(result.order.size()));
      result.order.insert(result.order.end(), node.blocks.begin() + first, node.blocks.begin() + end);
    }
  }
  result.panel_start.push_back(static_cast<int>(result.order.size()));
  return result;
}

}  // namespace

/// Rough cycles of one core for a panel of `own` blocks of columns and `below` blocks of rows under its square: its own
/// factor, what it gives to its ancestors, and its part in the solve of some sixty right-hand sides. Counted in
/// register tiles, which cost their depth and something besides.
double calcPanelCost(int own, int below) {
  constexpr double kTileRows = 24, kTileColumns = 9, kTileCycles = 60, kDepthCycles = 13.5;
  constexpr double kSquareCycles = 400, kPanelCycles = 250, kRightSides = 64;
  const double w = 3 * own, m = 3 * below;
  const auto tile = [](double depth) { return kTileCycles + kDepthCycles * depth; };
  const double columns = std::ceil(m / kTileColumns);
  const double given = columns * (m / (2 * kTileRows) + 0.5) * tile(w);
  const double factor = std::ceil(w / kTileColumns) * (kSquareCycles + (w / 2 + m) / kTileRows * tile(w / 2 + 15));
  const double solve = (columns + w / (2 * kTileColumns)) * kRightSides / kTileRows * tile(w);
  return kPanelCycles * (1 + m / 30) + given + factor + solve;
}

Elimination makeElimination(const BlockPattern& pattern, const BlockOrder& order, int threads) {
  SupernodeTree tree(pattern, order);
  tree.merge();
  Elimination elimination = tree.makeElimination();
  const FactorPattern factor(pattern.renumbered(elimination.order), elimination.panel_start);
  elimination.cost = makePanelShares(factor, threads).cost;
  return elimination;
}

// Along the body panels follow each other through the cache, which the estimate does not see.
Elimination makeElimination(const BlockPattern& pattern, int threads) {
  constexpr double kClearly = 0.95;
  Elimination best = makeElimination(pattern, orderFromBothEnds(pattern), threads);
  for (const auto& ordering : {orderByMinimumDegree, orderByNestedDissection}) {
    Elimination next = makeElimination(pattern, ordering(pattern), threads);
    if (next.cost < kClearly * best.cost) best = std::move(next);
  }
  return best;
}

}  // namespace sinew
