#include "sinew/inverse/contact_finder.h"

#include <algorithm>

#include "sinew/common/config_error.h"
#include "sinew/contact/proximity_detection.h"
#include "sinew/contact/volume_detection.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

constexpr double kCarriedTowards = 0.05;  // cosine of a carrier's way to a contact, below which it slides past

ProximitySettings makeSettings(const ContactDescription& contacts) {
  ProximitySettings settings;
  settings.contact_distance = contacts.contact_distance;
  settings.alarm_distance = contacts.alarm_distance;
  settings.max_depth = std::max(settings.max_depth, contacts.alarm_distance);
  return settings;
}

VolumeSettings makeVolumeSettings(const ContactDescription& contacts) {
  VolumeSettings settings;
  settings.contact_distance = contacts.contact_distance;
  settings.dilation = 2.5 * contacts.contact_distance;  // what moves farther in a cycle is seen late
  settings.pixels = contacts.resolution;
  return settings;
}

std::vector<ObstacleShape> gatherShapes(const RobotModel& robot) {
  std::vector<ObstacleShape> shapes;
  for (const Obstacle& obstacle : robot.obstacles()) {
    for (const Obstacle::Part& part : obstacle.parts) shapes.push_back(part.shape);
  }
  return shapes;
}

// Triangles of the surface with a corner that lies in the region at rest.
std::vector<int> findTriangles(const RobotModel& robot, int region) {
  const RegionDescription& description = robot.description().contacts.regions[region];
  const auto& triangles = robot.surface().triangles;
  std::vector<int> found;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (std::any_of(triangles[t].begin(), triangles[t].end(),
                    [&](int node) { return description.contains(robot.fem().rest()[node]); })) {
      found.push_back(static_cast<int>(t));
    }
  }
  if (found.empty()) {
    throw ConfigError(robot.description().file + ": contacts.regions[" + std::to_string(region) + "]",
                      "'" + description.name + "' without a node of the surface",
                      "boxes or spheres around a part of the surface, in m and in the frame of the mesh");
  }
  return found;
}

RegionPairs makeRegionPairs(const RobotModel& robot) {
  const ContactDescription& contacts = robot.description().contacts;
  const int triangles = static_cast<int>(robot.surface().triangles.size());
  RegionPairs pairs;
  for (const auto& pair : contacts.self_pairs) {
    pairs.add(findTriangles(robot, pair[0]), findTriangles(robot, pair[1]), triangles);
  }
  return pairs;
}

}  // namespace

struct ContactFinder::Impl {
  const RobotModel& robot;
  ContactList found, list;
  RegionPairs self_pairs;
  std::vector<ObstacleState> states, before;
  std::unique_ptr<ProximityDetection> proximity;  // null where there is nothing to touch
  std::unique_ptr<VolumeDetection> volume;        // of the volume method, for obstacles
  Vec3 carried;                                   // direction of a carrier

  explicit Impl(const RobotModel& model)
      : robot(model),
        found(std::max(1, model.maxContacts()), std::max(1, model.maxContactEntries())),
        list(std::max(1, model.maxContacts()), std::max(1, model.maxContactEntries())),
        carried(model.description().carrier.axis.normalized()) {
    for (const Obstacle& obstacle : model.obstacles()) states.push_back({obstacle.pose, true});
    before = states;
    if (model.maxContacts() == 0) return;
    const ContactDescription& contacts = model.description().contacts;
    self_pairs = makeRegionPairs(model);
    const CollisionSurface surface(model.surface().triangles);
    proximity = std::make_unique<ProximityDetection>(makeSettings(contacts), surface, model.fem().rest(),
                                                     gatherShapes(model), model.maxContacts());
    if (contacts.method == DetectionMethod::kProximity) return;
    volume = std::make_unique<VolumeDetection>(makeVolumeSettings(contacts), surface, gatherShapes(model),
                                               model.maxContacts());
  }

  void addObstacle(int shape, const Pose& pose) {
    if (volume) {
      volume->addObstacle(proximity->surface(), shape, pose, found);
    } else {
      proximity->addObstacle(shape, pose, found);
    }
  }

  void addObstacles() {
    int shape = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
      for (const Obstacle::Part& part : robot.obstacles()[i].parts) {
        if (states[i].present) addObstacle(shape, states[i].pose * part.origin);
        ++shape;
      }
    }
  }

  bool movable(int row) const {
    const ContactEntry* entries = found.entries(row);
    const ContactRow& contact = found.row(row);
    if (robot.hasCarrier() && contact.obstacle >= 0 && std::abs(contact.normal.dot(carried)) > kCarriedTowards) {
      return true;
    }
    return std::any_of(entries, entries + found.row(row).entries,
                       [this](const ContactEntry& entry) { return robot.fem().freeIndex(entry.node) >= 0; });
  }

  // Nothing gives way to a contact of fixed nodes, unless a carrier moves them.
  void keepMovable() {
    list.begin();
    for (int row = 0; row < found.size(); ++row) {
      if (movable(row)) list.add(found.row(row), found.entries(row), found.row(row).entries);
    }
    list.finish();
  }
};

ContactFinder::ContactFinder(const RobotModel& robot) : impl_(std::make_unique<Impl>(robot)) {}

ContactFinder::~ContactFinder() = default;

bool ContactFinder::active() const {
  return impl_->proximity != nullptr;
}

void ContactFinder::setObstacles(const std::vector<ObstacleState>& obstacles) {
  impl_->before = impl_->states;
  std::copy_n(obstacles.begin(), std::min(obstacles.size(), impl_->states.size()), impl_->states.begin());
}

const std::vector<ObstacleState>& ContactFinder::obstacles() const {
  return impl_->states;
}

const ContactList& ContactFinder::find(const std::vector<Vec3>& nodes, StageTimes& times) {
  const StageTimer timer(times.detection);
  impl_->found.begin();
  if (impl_->proximity) {
    impl_->proximity->update(nodes);
    impl_->addObstacles();
    if (impl_->robot.description().contacts.self) impl_->proximity->addSelf(impl_->self_pairs, impl_->found);
  }
  impl_->found.finish();
  impl_->keepMovable();
  return impl_->list;
}

ContactFinder::Placed ContactFinder::part(int index) const {
  int obstacle = 0;
  const std::vector<Obstacle>& obstacles = impl_->robot.obstacles();
  for (; index >= static_cast<int>(obstacles[obstacle].parts.size()); ++obstacle) {
    index -= static_cast<int>(obstacles[obstacle].parts.size());
  }
  const Obstacle::Part& part = obstacles[obstacle].parts[index];
  return {&part.shape, impl_->states[obstacle].pose * part.origin, obstacle};
}

double ContactFinder::calcGapShift(int row) const {
  const ContactRow& contact = impl_->list.row(row);
  if (contact.obstacle < 0) return 0;
  const int obstacle = part(contact.obstacle).obstacle;
  const Vec3 there = impl_->before[obstacle].pose * (impl_->states[obstacle].pose.inverse() * contact.other_point);
  return -contact.normal.dot(contact.other_point - there);
}

bool ContactFinder::crowded() const {
  const ContactDescription& contacts = impl_->robot.description().contacts;
  return impl_->found.leastDroppedGap() < 0.5 * (contacts.alarm_distance - contacts.contact_distance);
}

const ContactList& ContactFinder::list() const {
  return impl_->list;
}

}  // namespace sinew
