#include "sinew/fem/fem_model.h"

#include <algorithm>
#include <utility>

#include "sinew/linalg/elimination.h"

namespace sinew {
namespace {

/// The nodes that move, in mesh order.
std::vector<int> listFreeNodes(const TetMesh& mesh, const std::vector<bool>& fixed) {
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const auto& tet : mesh.tets) {
    for (int node : tet) used[node] = true;
  }
  std::vector<int> nodes;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i] && !fixed[i]) nodes.push_back(static_cast<int>(i));
  }
  return nodes;
}

std::vector<int> numberNodes(const TetMesh& mesh, const std::vector<int>& order) {
  std::vector<int> index(mesh.nodes.size(), -1);
  for (std::size_t k = 0; k < order.size(); ++k) index[order[k]] = static_cast<int>(k);
  return index;
}

BlockPattern makePattern(const TetMesh& mesh, const std::vector<int>& free_index,
                         const std::vector<std::vector<int>>& couplings, std::size_t free) {
  std::vector<std::vector<int>> cliques;
  cliques.reserve(mesh.tets.size() + couplings.size());
  for (const auto& tet : mesh.tets) cliques.emplace_back(tet.begin(), tet.end());
  cliques.insert(cliques.end(), couplings.begin(), couplings.end());
  for (auto& clique : cliques) {
    for (int& node : clique) node = free_index[node];
  }
  return BlockPattern(static_cast<int>(free), cliques);
}

// Forces and blocks of fixed nodes are weighed with 0 and then added to those of the first free one.
void fillLane(const FemModel::Element& element, const FemModel& model, int lane, TetBatch& batch) {
  for (int a = 0; a < 4; ++a) {
    const int row = model.freeIndex(element.nodes[a]);
    batch.free[a][lane] = row < 0 ? 0 : 1;
    batch.any_fixed = batch.any_fixed || row < 0;
    batch.position[a][lane] = 3U * static_cast<unsigned>(element.nodes[a]);
    batch.force[a][lane] = row < 0 ? 0 : 4U * static_cast<unsigned>(row);
  }
  for (int i = 0; i < 9; ++i) batch.gradients[i][lane] = element.shape.gradients(i % 3, 1 + i / 3);
  batch.volume[lane] = element.shape.volume;
  batch.lambda[lane] = element.lame.lambda;
  batch.mu[lane] = element.lame.mu;
  for (int k = 0; k < 10; ++k) {
    const BlockSlot slot = element.slots[k].first < 0 ? model.pattern().slot(0, 0) : element.slots[k];
    batch.first[k][lane] = static_cast<unsigned>(slot.first);
    batch.stride[k][lane] = static_cast<unsigned>(slot.stride);
  }
}

std::vector<TetBatch> makeBatches(const FemModel& model) {
  const std::vector<FemModel::Element>& elements = model.elements();
  const std::size_t count = model.freeCount() > 0 ? elements.size() : 0;
  std::vector<TetBatch> batches((count + TetBatch::kSize - 1) / TetBatch::kSize, TetBatch());
  for (std::size_t i = 0; i < TetBatch::kSize * batches.size(); ++i) {
    const int lane = static_cast<int>(i / batches.size());
    TetBatch& batch = batches[i % batches.size()];
    fillLane(elements[std::min(i, count - 1)], model, lane, batch);
    if (i >= count) batch.volume[lane] = 0;
  }
  return batches;
}

}  // namespace

FemModel::Numbering FemModel::makeNumbering(const TetMesh& mesh, const std::vector<bool>& fixed,
                                            const std::vector<std::vector<int>>& couplings, int threads) {
  const std::vector<int> nodes = listFreeNodes(mesh, fixed);
  const BlockPattern in_mesh_order = makePattern(mesh, numberNodes(mesh, nodes), couplings, nodes.size());
  const Elimination elimination = makeElimination(in_mesh_order, threads);
  std::vector<int> order;
  for (const int block : elimination.order) order.push_back(nodes[block]);
  return {numberNodes(mesh, order),
          FactorPattern(in_mesh_order.renumbered(elimination.order), elimination.panel_start)};
}

FemModel::FemModel(const TetMesh& mesh, const std::vector<Material>& material, const std::vector<bool>& fixed,
                   const std::vector<std::vector<int>>& couplings, int threads)
    : FemModel(mesh, material, makeNumbering(mesh, fixed, couplings, threads)) {}

FemModel::FemModel(const TetMesh& mesh, const std::vector<Material>& material, Numbering numbering)
    : rest_(mesh.nodes),
      free_index_(std::move(numbering.free_index)),
      free_nodes_(static_cast<std::size_t>(numbering.factor.matrix().blocks())),
      factor_(std::move(numbering.factor)),
      mass_(VecX::Zero(pattern().blocks())) {
  for (std::size_t i = 0; i < free_index_.size(); ++i) {
    if (free_index_[i] >= 0) free_nodes_[free_index_[i]] = static_cast<int>(i);
  }
  elements_.reserve(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Element element;
    element.nodes = mesh.tets[t];
    std::sort(element.nodes.begin(), element.nodes.end(),
              [&](int a, int b) { return free_index_[a] < free_index_[b]; });
    std::array<Vec3, 4> corners;
    for (int a = 0; a < 4; ++a) corners[a] = rest_[element.nodes[a]];
    element.shape = makeTetShape(corners);
    element.lame = material[t].lame;
    for (int a = 0, k = 0; a < 4; ++a) {
      const int row = free_index_[element.nodes[a]];
      if (row >= 0) mass_[row] += material[t].density * element.shape.volume / 4;
      for (int b = 0; b <= a; ++b, ++k) {
        const int column = free_index_[element.nodes[b]];
        if (row >= 0 && column >= 0) element.slots[k] = pattern().slot(row, column);
      }
    }
    elements_.push_back(element);
  }
  batches_ = makeBatches(*this);
}

}  // namespace sinew
