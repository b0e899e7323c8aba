#include "sinew/inverse/contact_finder.h"

#include <algorithm>

#include "sinew/contact/proximity_detection.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

ProximitySettings makeSettings(const ContactDescription& contacts) {
  ProximitySettings settings;
  settings.contact_distance = contacts.contact_distance;
  settings.alarm_distance = contacts.alarm_distance;
  settings.max_depth = std::max(settings.max_depth, contacts.alarm_distance);
  return settings;
}

std::vector<ObstacleShape> gatherShapes(const RobotModel& robot) {
  std::vector<ObstacleShape> shapes;
  for (const Obstacle& obstacle : robot.obstacles()) {
    for (const Obstacle::Part& part : obstacle.parts) shapes.push_back(part.shape);
  }
  return shapes;
}

}  // namespace

struct ContactFinder::Impl {
  const RobotModel& robot;
  ContactList list;
  std::vector<ObstacleState> states;
  std::unique_ptr<ProximityDetection> proximity;  // null where there is nothing to touch

  explicit Impl(const RobotModel& model)
      : robot(model), list(std::max(1, model.maxContacts()), std::max(1, model.maxContactEntries())) {
    for (const Obstacle& obstacle : model.obstacles()) states.push_back({obstacle.pose, true});
    if (model.maxContacts() == 0) return;
    proximity = std::make_unique<ProximityDetection>(makeSettings(model.description().contacts),
                                                     CollisionSurface(model.surface().triangles), model.fem().rest(),
                                                     gatherShapes(model), model.maxContacts());
  }

  void addObstacles() {
    int shape = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
      for (const Obstacle::Part& part : robot.obstacles()[i].parts) {
        if (states[i].present) proximity->addObstacle(shape, states[i].pose * part.origin, list);
        ++shape;
      }
    }
  }
};

ContactFinder::ContactFinder(const RobotModel& robot) : impl_(std::make_unique<Impl>(robot)) {}

ContactFinder::~ContactFinder() = default;

bool ContactFinder::active() const {
  return impl_->proximity != nullptr;
}

void ContactFinder::setObstacles(const std::vector<ObstacleState>& obstacles) {
  std::copy_n(obstacles.begin(), std::min(obstacles.size(), impl_->states.size()), impl_->states.begin());
}

const std::vector<ObstacleState>& ContactFinder::obstacles() const {
  return impl_->states;
}

const ContactList& ContactFinder::find(const std::vector<Vec3>& nodes, StageTimes& times) {
  const StageTimer timer(times.detection);
  impl_->list.begin();
  if (impl_->proximity) {
    impl_->proximity->update(nodes);
    impl_->addObstacles();
  }
  impl_->list.finish();
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

const ContactList& ContactFinder::list() const {
  return impl_->list;
}

}  // namespace sinew
