#include "sinew/linalg/ordering.h"

#include <amd.h>
#include <metis.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace sinew {
namespace {

/// Distance of every block from the nearest of `seeds`, in edges; blocks that none reaches stay at -1.
std::vector<int> calcDistance(const BlockGraph& graph, std::vector<int> seeds) {
  std::vector<int> distance(static_cast<std::size_t>(graph.blocks()), -1);
  for (const int seed : seeds) distance[seed] = 0;
  for (std::size_t next = 0; next < seeds.size(); ++next) {
    const int block = seeds[next];
    for (int k = graph.start[block]; k < graph.start[block + 1]; ++k) {
      const int other = graph.neighbour[k];
      if (distance[other] >= 0) continue;
      distance[other] = distance[block] + 1;
      seeds.push_back(other);
    }
  }
  return distance;
}

int findFarthest(const std::vector<int>& distance) {
  return static_cast<int>(std::max_element(distance.begin(), distance.end()) - distance.begin());
}

/// Layers of equal distance from a whole end face, not from one corner of it: all blocks about as far from the other
/// end as the farthest one is.
std::vector<int> calcLayers(const BlockGraph& graph, int inside) {
  const int end = findFarthest(calcDistance(graph, {inside}));
  const std::vector<int> from_end = calcDistance(graph, {end});
  const int other = findFarthest(from_end);
  const std::vector<int> from_other = calcDistance(graph, {other});
  const int reach = from_other[end];
  std::vector<int> face;
  for (int i = 0; i < graph.blocks(); ++i) {
    if (from_other[i] >= reach) face.push_back(i);
  }
  return calcDistance(graph, face);
}

}  // namespace

BlockGraph::BlockGraph(const BlockPattern& pattern) : start(static_cast<std::size_t>(pattern.blocks()) + 1, 0) {
  const std::vector<int>& columns = pattern.columnStart();
  for (int j = 0; j < pattern.blocks(); ++j) {
    for (int k = columns[j] + 1; k < columns[j + 1]; ++k) {
      ++start[j + 1];
      ++start[pattern.rows()[k] + 1];
    }
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  neighbour.resize(static_cast<std::size_t>(start.back()));
  std::vector<int> next(start.begin(), start.end() - 1);
  for (int j = 0; j < pattern.blocks(); ++j) {
    for (int k = columns[j] + 1; k < columns[j + 1]; ++k) {
      const int i = pattern.rows()[k];
      neighbour[next[j]++] = i;
      neighbour[next[i]++] = j;
    }
  }
}

BlockOrder orderByMinimumDegree(const BlockPattern& pattern) {
  BlockOrder order(static_cast<std::size_t>(pattern.blocks()));
  const int status =
      amd_order(pattern.blocks(), pattern.columnStart().data(), pattern.rows().data(), order.data(), nullptr, nullptr);
  if (status != AMD_OK) throw std::runtime_error("minimum degree ordering failed");
  return order;
}

BlockOrder orderByNestedDissection(const BlockPattern& pattern) {
  const BlockGraph graph(pattern);
  if (graph.neighbour.empty()) return orderByMinimumDegree(pattern);
  std::vector<idx_t> start(graph.start.begin(), graph.start.end());
  std::vector<idx_t> neighbour(graph.neighbour.begin(), graph.neighbour.end());
  idx_t blocks = pattern.blocks();
  std::vector<idx_t> order(static_cast<std::size_t>(blocks)), place(static_cast<std::size_t>(blocks));
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const int status =
      METIS_NodeND(&blocks, start.data(), neighbour.data(), nullptr, options, order.data(), place.data());
  if (status != METIS_OK) throw std::runtime_error("nested dissection failed");
  return BlockOrder(order.begin(), order.end());
}

BlockOrder orderFromBothEnds(const BlockPattern& pattern) {
  const BlockGraph graph(pattern);
  std::vector<int> layer(static_cast<std::size_t>(graph.blocks()), -1);
  for (int i = 0; i < graph.blocks(); ++i) {
    if (layer[i] >= 0) continue;
    const std::vector<int> layers = calcLayers(graph, i);  // of the part of the body that i lies in
    const int last = *std::max_element(layers.begin(), layers.end());
    for (int j = 0; j < graph.blocks(); ++j) {
      if (layers[j] >= 0) layer[j] = std::min(layers[j], last - layers[j]);
    }
  }
  BlockOrder order(static_cast<std::size_t>(graph.blocks()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&layer](int a, int b) { return layer[a] < layer[b]; });
  return order;
}

}  // namespace sinew
