#include "sinew/linalg/panel_shares.h"

#include <algorithm>

#include "sinew/linalg/elimination.h"

namespace sinew {
namespace {

/// A panel and all that comes before it in the tree.
struct Branch {
  int root;
  double cost;
};

std::vector<Branch> makeBranches(const FactorPattern& pattern) {
  const auto& panels = pattern.panels();
  std::vector<Branch> branches;
  branches.reserve(panels.size());
  for (int p = 0; p < static_cast<int>(panels.size()); ++p) {
    branches.push_back({p, calcPanelCost(panels[p].own, panels[p].below_count)});
  }
  for (const Branch& branch : branches) {
    const int parent = panels[branch.root].parent;
    if (parent >= 0) branches[parent].cost += branch.cost;
  }
  return branches;
}

std::vector<std::vector<int>> listChildren(const FactorPattern& pattern) {
  std::vector<std::vector<int>> children(pattern.panels().size());
  for (int p = 0; p < static_cast<int>(children.size()); ++p) {
    const int parent = pattern.panels()[p].parent;
    if (parent >= 0) children[parent].push_back(p);
  }
  return children;
}

void addPanels(const std::vector<std::vector<int>>& children, int root, std::vector<int>& panels) {
  std::vector<int> open = {root};
  while (!open.empty()) {
    const int panel = open.back();
    open.pop_back();
    panels.push_back(panel);
    open.insert(open.end(), children[panel].begin(), children[panel].end());
  }
}

bool isHeavier(const Branch& a, const Branch& b) {
  return a.cost > b.cost;
}

/// Each branch to the thread that has least to do; the heaviest first.
std::vector<std::vector<Branch>> deal(std::vector<Branch> branches, int threads, double& heaviest) {
  std::vector<std::vector<Branch>> dealt(static_cast<std::size_t>(threads));
  std::vector<double> load(static_cast<std::size_t>(threads), 0.0);
  std::stable_sort(branches.begin(), branches.end(), isHeavier);
  for (const Branch& branch : branches) {
    const auto least = static_cast<std::size_t>(std::min_element(load.begin(), load.end()) - load.begin());
    dealt[least].push_back(branch);
    load[least] += branch.cost;
  }
  heaviest = *std::max_element(load.begin(), load.end());
  return dealt;
}

}  // namespace

// Cuts the heaviest branch at its root again and again, and keeps the cut with the shortest way through the heaviest
// thread and the trunk.
PanelShares makePanelShares(const FactorPattern& pattern, int threads) {
  const auto& panels = pattern.panels();
  const std::vector<Branch> all = makeBranches(pattern);
  const std::vector<std::vector<int>> children = listChildren(pattern);
  std::vector<Branch> branches;
  for (const Branch& branch : all) {
    if (panels[branch.root].parent < 0) branches.push_back(branch);
  }
  std::vector<int> trunk, best_trunk;
  double trunk_cost = 0;
  PanelShares shares;
  std::vector<std::vector<Branch>> best = deal(branches, threads, shares.cost);
  while (threads > 1 && trunk_cost < shares.cost) {
    const auto heaviest = std::min_element(branches.begin(), branches.end(), isHeavier);
    const int root = heaviest->root;
    branches.erase(heaviest);
    trunk.push_back(root);
    trunk_cost += calcPanelCost(panels[root].own, panels[root].below_count);
    for (const int child : children[root]) branches.push_back(all[child]);
    if (branches.empty()) break;
    double cost = 0;
    std::vector<std::vector<Branch>> dealt = deal(branches, threads, cost);
    if (cost + trunk_cost >= shares.cost) continue;
    shares.cost = cost + trunk_cost;
    best = std::move(dealt);
    best_trunk = trunk;
  }
  std::sort(best_trunk.begin(), best_trunk.end());
  shares.trunk = best_trunk;
  for (const std::vector<Branch>& dealt : best) {
    shares.branches.emplace_back();
    for (const Branch& branch : dealt) addPanels(children, branch.root, shares.branches.back());
    std::sort(shares.branches.back().begin(), shares.branches.back().end());
  }
  return shares;
}

}  // namespace sinew
