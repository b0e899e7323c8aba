#include "target_trajectory.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "sinew/common/config_error.h"

namespace sinew {

namespace {

constexpr double kTurn = 6.283185307179586;  // rad

std::vector<std::string> splitLine(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    const auto first = field.find_first_not_of(" \t\r");
    const auto last = field.find_last_not_of(" \t\r");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
  }
  return fields;
}

double readNumber(const std::string& field, const std::string& place) {
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  if (field.empty() || *end != '\0' || !std::isfinite(value)) {
    throw ConfigError(place, field.empty() ? "nothing" : field, "a finite number");
  }
  return value;
}

/// Columns of the header line by name, and of each effector the three that hold its position.
class CsvHeader {
 public:
  CsvHeader(const std::string& path, const std::string& line) : path_(path) {
    const std::vector<std::string> names = splitLine(line);
    count_ = names.size();
    for (std::size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
    for (const std::string& name : names) {
      const std::string prefix = "target_";
      if (name.size() > prefix.size() + 2 && name.compare(0, prefix.size(), prefix) == 0 &&
          name.compare(name.size() - 2, 2, "_x") == 0) {
        effectors_.push_back(name.substr(prefix.size(), name.size() - prefix.size() - 2));
      }
    }
    if (effectors_.empty()) {
      throw ConfigError(path, "no column target_NAME_x", "columns t, target_NAME_x, target_NAME_y, target_NAME_z");
    }
  }

  const std::vector<std::string>& effectors() const { return effectors_; }
  std::size_t count() const { return count_; }

  std::size_t column(const std::string& name) const {
    const auto found = columns_.find(name);
    if (found == columns_.end()) throw ConfigError(path_, "no column " + name, "one column of that name");
    return found->second;
  }

 private:
  std::string path_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> effectors_;
  std::size_t count_ = 0;
};

}  // namespace

TargetTrajectory TargetTrajectory::makeCircle(const std::string& effector, const Vec3& centre, double radius,
                                              const TrajectoryTiming& timing) {
  TargetTrajectory trajectory;
  Path path;
  path.shape = Path::Shape::kCircle;
  path.centre = centre;
  path.radius = radius;
  trajectory.effectors_.push_back(effector);
  trajectory.paths_.push_back(path);
  trajectory.period_ = timing.period;
  trajectory.duration_ = timing.period * timing.turns;
  return trajectory;
}

TargetTrajectory TargetTrajectory::makeSquare(const std::string& effector, const Vec3& centre, double radius,
                                              const TrajectoryTiming& timing) {
  TargetTrajectory trajectory = makeCircle(effector, centre, radius, timing);
  Path& path = trajectory.paths_.front();
  path.shape = Path::Shape::kPolygon;
  path.points = {centre + Vec3(radius, 0, 0), centre + Vec3(0, radius, 0), centre - Vec3(radius, 0, 0),
                 centre - Vec3(0, radius, 0)};
  return trajectory;
}

TargetTrajectory TargetTrajectory::makeSShape(const std::string& tip, const Vec3& tip_centre, double radius,
                                              const std::string& middle, const Vec3& middle_centre,
                                              double middle_radius, const TrajectoryTiming& timing) {
  TargetTrajectory trajectory = makeCircle(tip, tip_centre, radius, timing);
  const TargetTrajectory opposite = makeCircle(middle, middle_centre, middle_radius, timing);
  trajectory.effectors_.push_back(middle);
  trajectory.paths_.push_back(opposite.paths_.front());
  trajectory.paths_.back().phase = kTurn / 2;
  return trajectory;
}

TargetTrajectory TargetTrajectory::readCsv(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) {
    throw ConfigError(path, "no readable text", "a CSV file with a line of column names");
  }
  const CsvHeader header(path, line);
  TargetTrajectory trajectory;
  trajectory.effectors_ = header.effectors();
  trajectory.paths_.resize(header.effectors().size());
  const std::size_t time_column = header.column("t");
  for (int number = 2; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string place = path + ":" + std::to_string(number);
    const std::vector<std::string> fields = splitLine(line);
    if (fields.size() != header.count()) {
      throw ConfigError(place, std::to_string(fields.size()) + " fields", std::to_string(header.count()) + " fields");
    }
    const double time = readNumber(fields[time_column], place + ": t");
    if (!trajectory.times_.empty() && time <= trajectory.times_.back()) {
      throw ConfigError(place + ": t", fields[time_column], "a time after that of the line before");
    }
    trajectory.times_.push_back(time);
    for (std::size_t i = 0; i < trajectory.paths_.size(); ++i) {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) {
        const std::string name = "target_" + trajectory.effectors_[i] + "_" + "xyz"[axis];
        point[axis] = readNumber(fields[header.column(name)], place + ": " + name);
      }
      trajectory.paths_[i].points.push_back(point);
    }
  }
  if (trajectory.times_.empty()) throw ConfigError(path, "no line of numbers", "at least one");
  trajectory.duration_ = trajectory.times_.back() - trajectory.times_.front();
  return trajectory;
}

void TargetTrajectory::calcPositions(double time, std::vector<Vec3>& positions) const {
  const double inside = std::max(0.0, std::min(time, duration_));
  positions.clear();
  for (const Path& path : paths_) positions.push_back(calcPosition(path, inside));
}

void TargetTrajectory::calcVelocities(double time, std::vector<Vec3>& velocities) const {
  const double before = std::max(0.0, std::min(time - 5e-4, duration_));
  const double after = std::max(0.0, std::min(time + 5e-4, duration_));
  velocities.clear();
  for (const Path& path : paths_) {
    velocities.push_back(after > before
                             ? Vec3((calcPosition(path, after) - calcPosition(path, before)) / (after - before))
                             : Vec3(Vec3::Zero()));
  }
}

Vec3 TargetTrajectory::calcPosition(const Path& path, double time) const {
  if (path.shape == Path::Shape::kSamples) return calcSample(path, time);
  const double turns = time / period_;
  if (path.shape == Path::Shape::kCircle) {
    const double angle = kTurn * turns + path.phase;
    return path.centre + path.radius * Vec3(std::cos(angle), std::sin(angle), 0);
  }
  const auto corners = static_cast<double>(path.points.size());
  const double along = (turns - std::floor(turns)) * corners;
  const std::size_t corner = std::min(static_cast<std::size_t>(along), path.points.size() - 1);
  const Vec3& from = path.points[corner];
  const Vec3& to = path.points[(corner + 1) % path.points.size()];
  return from + (along - static_cast<double>(corner)) * (to - from);
}

Vec3 TargetTrajectory::calcSample(const Path& path, double time) const {
  const double at = times_.front() + time;
  const auto next = std::upper_bound(times_.begin(), times_.end(), at);
  if (next == times_.end()) return path.points.back();
  if (next == times_.begin()) return path.points.front();
  const auto right = static_cast<std::size_t>(next - times_.begin());
  const double fraction = (at - times_[right - 1]) / (times_[right] - times_[right - 1]);
  return path.points[right - 1] + fraction * (path.points[right] - path.points[right - 1]);
}

Vec3 calcRamp(const Vec3& start, const Vec3& end, const Vec3& velocity, double duration, double time) {
  const double s = duration > 0 ? std::max(0.0, std::min(time / duration, 1.0)) : 1.0;
  const double cube = s * s * s;
  const double travel = cube * (10 - 15 * s + 6 * s * s);
  const double lead = cube * (-4 + 7 * s - 3 * s * s);
  return start + travel * (end - start) + duration * lead * velocity;
}

}  // namespace sinew
