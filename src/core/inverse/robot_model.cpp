#include "sinew/inverse/robot_model.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <sstream>

#include "sinew/common/config_error.h"
#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/contact_warnings.h"
#include "sinew/mesh/embedding.h"
#include "sinew/mesh/quality.h"
#include "sinew/mesh/read_mesh.h"

namespace sinew {
namespace {

constexpr double kLockingPoissonRatio = 0.45;  // linear tetrahedra bend far too stiffly above
constexpr double kInside = 1e-6;               // m from the mesh that count as inside
constexpr double kCarried = 1e-6;              // share of a point below which a node does not carry it
constexpr double kFarOutside = 0.2;            // of the mesh's size, beyond which a point is a mistake

template <typename... Parts>
std::string join(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

std::map<int, double> volumeByRegion(const TetMesh& mesh) {
  std::map<int, double> volumes;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    volumes[mesh.region[t]] += std::abs(tetVolume(mesh, static_cast<int>(t)));
  }
  return volumes;
}

// Which description holds for a region: its own, or else the one for all others.
std::map<int, const MaterialDescription*> assignMaterials(const RobotDescription& robot,
                                                          const std::map<int, double>& volumes) {
  std::map<int, const MaterialDescription*> named;
  for (const MaterialDescription& material : robot.materials) named[material.region] = &material;
  std::map<int, const MaterialDescription*> assigned;
  for (const auto& [region, volume] : volumes) {
    const auto own = named.find(region) != named.end() ? named.find(region) : named.find(-1);
    if (own == named.end()) {
      throw ConfigError(robot.file + ": materials", join("no material for region ", region, " of the mesh"),
                        "one with that region, or one without a region for all others");
    }
    assigned[region] = own->second;
  }
  for (const auto& [region, material] : named) {
    if (region >= 0 && volumes.count(region) == 0) {
      std::string regions;
      for (const auto& present : volumes) regions += " " + std::to_string(present.first);
      throw ConfigError(robot.file + ": materials.region", std::to_string(region),
                        "one of the mesh's regions:" + regions);
    }
  }
  return assigned;
}

std::vector<Material> makeMaterials(const RobotDescription& robot, const TetMesh& mesh) {
  const std::map<int, double> volumes = volumeByRegion(mesh);
  const auto assigned = assignMaterials(robot, volumes);
  std::map<const MaterialDescription*, double> volume_of;
  for (const auto& [region, material] : assigned) volume_of[material] += volumes.at(region);
  std::vector<Material> materials(mesh.tets.size());
  for (std::size_t t = 0; t < materials.size(); ++t) {
    const MaterialDescription* material = assigned.at(mesh.region[t]);
    materials[t].lame = calcLame(material->young_modulus, material->poisson_ratio);
    materials[t].density = material->total_mass > 0 ? material->total_mass / volume_of.at(material) : material->density;
  }
  return materials;
}

std::vector<bool> markFixedNodes(const RobotDescription& robot, const TetMesh& mesh) {
  std::vector<bool> fixed(mesh.nodes.size(), false);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    fixed[i] = robot.fixed.contains(mesh.nodes[i]);
  }
  for (int node : robot.fixed.nodes) {
    if (node >= static_cast<int>(fixed.size())) {
      throw ConfigError(robot.file + ": fixed.nodes", std::to_string(node),
                        "a node index below " + std::to_string(fixed.size()));
    }
    fixed[node] = true;
  }
  return fixed;
}

// Three fixed nodes that are not on one line hold all six rigid motions of a piece.
void requireHeld(const RobotDescription& robot, const TetMesh& mesh, const std::vector<bool>& fixed,
                 const MeshReport& report, int piece) {
  std::vector<Vec3> held;
  int member = -1;
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (report.piece[i] != piece) continue;
    member = static_cast<int>(i);
    if (fixed[i]) held.push_back(mesh.nodes[i]);
  }
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : held) mean += x / static_cast<double>(held.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& x : held) spread += (x - mean) * (x - mean).transpose();
  const Vec3 widths = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  if (held.size() >= 3 && widths[1] > 1e-12 * widths[2]) return;
  const std::string where = report.pieces == 1 ? "" : join(" in the piece of node ", member);
  throw ConfigError(robot.file + ": fixed",
                    join(held.size(), " fixed nodes", held.size() < 3 ? "" : " on one line", where),
                    "three fixed nodes or more that are not on one line, so that no piece can move freely");
}

EmbeddedPoint embed(const RobotDescription& robot, const PointLocator& locator, double mesh_size, const Vec3& position,
                    const std::string& key, std::vector<std::string>& warnings) {
  const PointLocator::Result found = locator.locate(position);
  const std::string where = join("[", position.x(), ", ", position.y(), ", ", position.z(), "]");
  if (found.distance > kFarOutside * mesh_size) {
    throw ConfigError(robot.file + ": " + key, join(where, ", ", found.distance * 1e3, " mm outside the mesh"),
                      "a point in the mesh, in m and in the frame of the mesh");
  }
  if (found.distance > kInside) {
    warnings.push_back(join(key, ": ", where, " lies ", found.distance * 1e3,
                            " mm outside the mesh; carried by the nearest tetrahedron"));
  }
  return found.point;
}

void warnOfMaterials(const RobotDescription& robot, std::vector<std::string>& warnings) {
  for (const MaterialDescription& material : robot.materials) {
    if (material.poisson_ratio > kLockingPoissonRatio) {
      warnings.push_back(join("poisson_ratio ", material.poisson_ratio, " above ", kLockingPoissonRatio,
                              ": linear tetrahedra lock, the body bends too stiffly"));
    }
    if (material.young_modulus < 1e3) {
      warnings.push_back(
          join("young_modulus ", material.young_modulus, " Pa is softer than any silicone: given in kPa?"));
    }
    if (material.young_modulus > 1e11) {
      warnings.push_back(join("young_modulus ", material.young_modulus, " Pa is stiffer than steel"));
    }
    if (material.total_mass == 0 && material.density > 0 && material.density < 50) {
      warnings.push_back(join("density ", material.density, " kg/m3 is very light: given in g/cm3?"));
    }
  }
}

void requireMovable(const RobotDescription& robot, const FemModel& fem, const std::string& key,
                    const std::vector<EmbeddedPoint>& points) {
  for (const EmbeddedPoint& point : points) {
    for (int i = 0; i < 4; ++i) {
      if (fem.freeIndex(point.nodes[i]) >= 0 && std::abs(point.weights[i]) > kCarried) return;
    }
  }
  throw ConfigError(robot.file + ": " + key, "only fixed nodes around it", "a point that can move");
}

}  // namespace

RobotModel::RobotModel(const RobotDescription& description)
    : RobotModel(description, readMesh(description.mesh_file, description.mesh_scale)) {}

RobotModel::RobotModel(const RobotDescription& description, const TetMesh& mesh)
    : description_(description),
      mesh_(mesh),
      surface_(makeBoundarySurface(mesh)),
      actuators_(listActuators(description)) {
  const MeshReport report = checkMesh(mesh_, description.mesh_pieces);
  if (!report.errors.empty()) throw ConfigError(description.mesh_file, report.errors.front(), "a sound mesh");
  for (const std::string& warning : report.warnings) warnings_.push_back(description.mesh_file + ": " + warning);
  warnOfMaterials(description, warnings_);

  const std::vector<bool> fixed = markFixedNodes(description, mesh_);
  for (int piece = 0; piece < report.pieces; ++piece) requireHeld(description, mesh_, fixed, report, piece);
  size_ = (report.upper - report.lower).norm();
  const PointLocator locator(mesh_);
  std::vector<std::vector<EmbeddedPoint>> via_points;
  std::vector<std::vector<int>> couplings;
  for (std::size_t c = 0; c < description.cables.size(); ++c) {
    via_points.emplace_back();
    const CableDescription& cable = description.cables[c];
    for (std::size_t i = 0; i < cable.via_points.size(); ++i) {
      via_points.back().push_back(embed(description, locator, size_, cable.via_points[i],
                                        join("cables[", c, "].via_points[", i, "]"), warnings_));
      const EmbeddedPoint* before = i == 0 ? nullptr : &via_points.back()[i - 1];
      couplings.push_back(SegmentStiffness::coupledNodes(before, via_points.back()[i]));
    }
  }
  fem_ = std::make_unique<FemModel>(mesh_, makeMaterials(description, mesh_), fixed, couplings,
                                    description.control.threads);
  for (std::size_t c = 0; c < description.cables.size(); ++c) {
    requireMovable(description, *fem_, join("cables[", c, "].via_points"), via_points[c]);
    cables_.emplace_back(description.cables[c], *fem_, via_points[c]);
    if (std::isfinite(description.cables[c].displacement.max) &&
        description.cables[c].displacement.max > cables_.back().restLength()) {
      throw ConfigError(description.file + ": " + join("cables[", c, "].displacement.max"),
                        join(description.cables[c].displacement.max, " m"),
                        join("less than the cable's rest length, ", cables_.back().restLength(), " m"));
    }
  }
  for (std::size_t e = 0; e < description.effectors.size(); ++e) {
    const std::string key = join("effectors[", e, "].point");
    const EmbeddedPoint point = embed(description, locator, size_, description.effectors[e].point, key, warnings_);
    requireMovable(description, *fem_, key, {point});
    effectors_.emplace_back(description.effectors[e], point);
  }
  for (const ObstacleDescription& obstacle : description.obstacles) obstacles_.push_back(makeObstacle(obstacle));
  for (const std::string& warning : findContactWarnings(*this)) warnings_.push_back(warning);
}

RobotModel::~RobotModel() = default;

double RobotModel::actuatorLength(int actuator) const {
  return actuator < static_cast<int>(cables_.size()) ? cables_[actuator].restLength() : size_;
}

int RobotModel::effectorCount() const {
  return static_cast<int>(effectors_.size());
}

int RobotModel::effectorRows() const {
  int rows = 0;
  for (const PointEffector& effector : effectors_) rows += effector.rowCount();
  return rows;
}

double RobotModel::maxNodeStep() const {
  const double step = description_.control.max_node_step;
  return maxContacts() > 0 ? std::min(step, description_.contacts.alarm_distance) : step;
}

int RobotModel::maxContacts() const {
  const bool touches = !obstacles_.empty() || description_.contacts.self;
  return touches ? description_.contacts.max_contacts : 0;
}

int RobotModel::maxContactEntries() const {
  constexpr int kEntries = 6;  // three nodes on either side
  int entries = kEntries * maxContacts();
  if (description_.contacts.method == DetectionMethod::kProximity) return entries;
  for (const Obstacle& obstacle : obstacles_) {  // regions share nodes at their borders only
    entries += 2 * static_cast<int>(surface_.nodes.size() * obstacle.parts.size());
  }
  return entries;
}

int RobotModel::findActuator(const std::string& name) const {
  for (int i = 0; i < actuatorCount(); ++i) {
    if (actuators_[i].name == name) return i;
  }
  return -1;
}

int RobotModel::findEffector(const std::string& name) const {
  for (int i = 0; i < effectorCount(); ++i) {
    if (effectors_[i].description().name == name) return i;
  }
  return -1;
}

int RobotModel::findObstacle(const std::string& name) const {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    if (obstacles_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace sinew
