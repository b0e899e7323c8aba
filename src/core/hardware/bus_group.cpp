#include "sinew/hardware/bus_group.h"

#include <algorithm>
#include <utility>

namespace sinew {

BusGroup::BusGroup(std::vector<Member> members) {
  std::size_t actuators = 0;
  for (Member& m : members) {
    const std::size_t size = m.actuators.size();
    buses_.push_back({{std::move(m)}, SetUpProgress::kBusy, std::vector<double>(size), std::vector<bool>(size)});
    actuators += size;
  }
  readings_.resize(actuators);
  for (const Bus& b : buses_) collect(b);
}

bool BusGroup::open(std::string& why) {
  bool all = true;
  for (Bus& b : buses_) {
    std::string one;
    if (b.bus->isOpen() || b.bus->open(one)) continue;
    why = buses_.size() > 1 ? b.name + ": " + one : one;
    all = false;
  }
  return all;
}

void BusGroup::close() {
  for (Bus& b : buses_) b.bus->close();
}

bool BusGroup::isOpen() const {
  return std::any_of(buses_.begin(), buses_.end(), [](const Bus& b) { return b.bus->isOpen(); });
}

void BusGroup::startSetUp(bool home_all) {
  problem_.clear();
  for (Bus& b : buses_) {
    b.bus->startSetUp(home_all);
    b.progress = SetUpProgress::kBusy;
  }
}

SetUpProgress BusGroup::updateSetUp(Time now) {
  bool done = true;
  for (Bus& b : buses_) {
    if (b.progress == SetUpProgress::kBusy) {
      b.progress = b.bus->updateSetUp(now);
      for (std::size_t k = 0; k < b.actuators.size(); ++k) b.set_points[k] = b.bus->readings()[k].measured;
    } else if (b.progress == SetUpProgress::kDone) {
      serve(b, now);  // its devices are on, and would miss their master while those of other buses are set up
    }
    collect(b);
    if (b.progress == SetUpProgress::kFailed && problem_.empty()) problem_ = b.bus->problem();
    done = done && b.progress == SetUpProgress::kDone;
  }
  collectCounters();
  if (!problem_.empty()) return SetUpProgress::kFailed;
  return done ? SetUpProgress::kDone : SetUpProgress::kBusy;
}

void BusGroup::serve(Bus& bus, Time now) {
  if (bus.bus->writeSetPoints(bus.set_points.data(), now) && bus.bus->read(now)) return;
  lose(bus);
}

bool BusGroup::writeSetPoints(const double* set_points, Time now) {
  bool all = true;
  for (Bus& b : buses_) {
    for (std::size_t k = 0; k < b.actuators.size(); ++k)
      b.set_points[k] = set_points[static_cast<std::size_t>(b.actuators[k])];
    if (b.bus->isOpen() && b.bus->writeSetPoints(b.set_points.data(), now)) continue;
    lose(b);
    all = false;
  }
  return all;
}

bool BusGroup::read(Time now) {
  bool all = true;
  for (Bus& b : buses_) {
    const bool ok = b.bus->isOpen() && b.bus->read(now);
    collect(b);
    if (ok) continue;
    lose(b);
    all = false;
  }
  collectCounters();
  return all;
}

bool BusGroup::relax(const std::vector<bool>& which, double share) {
  bool all = true;
  for (Bus& b : buses_) {
    choose(b, which);
    all = b.bus->isOpen() && b.bus->relax(b.which, share) && all;
  }
  return all;
}

bool BusGroup::switchOff(const std::vector<bool>& which) {
  bool all = true;
  for (Bus& b : buses_) {
    choose(b, which);
    all = b.bus->isOpen() && b.bus->switchOff(b.which) && all;
  }
  return all;
}

void BusGroup::setZero(int i, double displacement) {
  for (Bus& b : buses_)
    for (std::size_t k = 0; k < b.actuators.size(); ++k)
      if (b.actuators[k] == i) b.bus->setZero(static_cast<int>(k), displacement), collect(b);
}

double BusGroup::zeroCounts(int i) const {
  const auto [bus, k] = find(i);
  return bus->bus->zeroCounts(k);
}

void BusGroup::restoreZero(int i, double counts) {
  const auto [bus, k] = find(i);
  bus->bus->restoreZero(k, counts);
}

std::string BusGroup::faultDetail(int i) const {
  const auto [bus, k] = find(i);
  return bus->bus->faultDetail(k);
}

std::pair<const BusGroup::Bus*, int> BusGroup::find(int i) const {
  for (const Bus& b : buses_)
    for (std::size_t k = 0; k < b.actuators.size(); ++k)
      if (b.actuators[k] == i) return {&b, static_cast<int>(k)};
  return {nullptr, 0};
}

void BusGroup::collect(const Bus& bus) {
  const std::vector<ActuatorReading>& own = bus.bus->readings();
  for (std::size_t k = 0; k < bus.actuators.size(); ++k) readings_[static_cast<std::size_t>(bus.actuators[k])] = own[k];
}

void BusGroup::collectCounters() {
  counters_ = {};
  for (const Bus& b : buses_) {
    const BusCounters& c = b.bus->counters();
    counters_.corrupted += c.corrupted;
    counters_.missing += c.missing;
    counters_.device_error += c.device_error;
    counters_.stale += c.stale;
  }
}

// What a closed bus read last is no measurement of now.
void BusGroup::lose(Bus& bus) {
  bus.bus->close();
  for (const int i : bus.actuators) readings_[static_cast<std::size_t>(i)].valid = false;
  problem_ = buses_.size() > 1 ? "the line of " + bus.name + " is gone" : "the line to the devices is gone";
}

void BusGroup::choose(Bus& bus, const std::vector<bool>& which) {
  for (std::size_t k = 0; k < bus.actuators.size(); ++k)
    bus.which[k] = which[static_cast<std::size_t>(bus.actuators[k])];
}

}  // namespace sinew
