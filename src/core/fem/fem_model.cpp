#include "sinew/fem/fem_model.h"

#include <algorithm>

namespace sinew {
namespace {

std::vector<int> numberFreeNodes(const TetMesh& mesh, const std::vector<bool>& fixed) {
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const auto& tet : mesh.tets) {
    for (int node : tet) used[node] = true;
  }
  std::vector<int> index(mesh.nodes.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (used[i] && !fixed[i]) index[i] = next++;
  }
  return index;
}

BlockPattern makePattern(const TetMesh& mesh, const std::vector<int>& free_index,
                         const std::vector<std::vector<int>>& couplings) {
  std::vector<std::vector<int>> cliques;
  cliques.reserve(mesh.tets.size() + couplings.size());
  for (const auto& tet : mesh.tets) cliques.emplace_back(tet.begin(), tet.end());
  cliques.insert(cliques.end(), couplings.begin(), couplings.end());
  for (auto& clique : cliques) {
    for (int& node : clique) node = free_index[node];
  }
  const auto free = std::count_if(free_index.begin(), free_index.end(), [](int i) { return i >= 0; });
  return BlockPattern(static_cast<int>(free), cliques);
}

}  // namespace

FemModel::FemModel(const TetMesh& mesh, const std::vector<Material>& material, const std::vector<bool>& fixed,
                   const std::vector<std::vector<int>>& couplings)
    : rest_(mesh.nodes),
      free_index_(numberFreeNodes(mesh, fixed)),
      pattern_(makePattern(mesh, free_index_, couplings)),
      mass_(VecX::Zero(pattern_.blocks())) {
  for (std::size_t i = 0; i < free_index_.size(); ++i) {
    if (free_index_[i] >= 0) free_nodes_.push_back(static_cast<int>(i));
  }
  elements_.reserve(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Element element;
    element.nodes = mesh.tets[t];
    std::sort(element.nodes.begin(), element.nodes.end());
    std::array<Vec3, 4> corners;
    for (int a = 0; a < 4; ++a) corners[a] = rest_[element.nodes[a]];
    element.shape = makeTetShape(corners);
    element.lame = material[t].lame;
    for (int a = 0, k = 0; a < 4; ++a) {
      const int row = free_index_[element.nodes[a]];
      if (row >= 0) mass_[row] += material[t].density * element.shape.volume / 4;
      for (int b = 0; b <= a; ++b, ++k) {
        const int column = free_index_[element.nodes[b]];
        if (row >= 0 && column >= 0) element.slots[k] = pattern_.slot(row, column);
      }
    }
    elements_.push_back(element);
  }
}

FemData::FemData(const FemModel& model)
    : force(VecX::Zero(model.size())), tangent(model.pattern()), rotations(model.elements().size(), Mat3::Identity()) {}

namespace {

TetGradients gather(const FemModel::Element& element, const std::vector<Vec3>& positions) {
  TetGradients x;
  for (int a = 0; a < 4; ++a) x.col(a) = positions[element.nodes[a]];
  return x;
}

void scatter(const FemModel& model, const FemModel::Element& element, const TetGradients& forces, VecX& force) {
  for (int a = 0; a < 4; ++a) {
    const int row = model.freeIndex(element.nodes[a]);
    if (row >= 0) force.segment<3>(3 * row) += forces.col(a);
  }
}

}  // namespace

void assemble(const FemModel& model, const std::vector<Vec3>& positions, Tangent tangent, FemData& data) {
  data.force.setZero();
  data.tangent.setZero();
  TetLinearisation result;
  for (std::size_t t = 0; t < model.elements().size(); ++t) {
    const FemModel::Element& element = model.elements()[t];
    calcTetLinearisation(element.shape, element.lame, gather(element, positions), tangent, data.rotations[t], result);
    scatter(model, element, result.forces, data.force);
    for (int k = 0; k < 10; ++k) {
      if (element.slots[k].first >= 0) data.tangent.add(element.slots[k], result.stiffness[k]);
    }
  }
}

void assembleForces(const FemModel& model, const std::vector<Vec3>& positions, FemData& data) {
  data.force.setZero();
  TetGradients forces;
  for (std::size_t t = 0; t < model.elements().size(); ++t) {
    const FemModel::Element& element = model.elements()[t];
    calcTetForces(element.shape, element.lame, gather(element, positions), data.rotations[t], forces);
    scatter(model, element, forces, data.force);
  }
}

}  // namespace sinew
