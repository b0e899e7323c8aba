#include "simulate_run.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::string formatNumber(double value) {
  char text[32];
  for (int digits = 15; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

void addPoint(const std::string& name, std::vector<std::string>& columns) {
  for (const char* axis : {"_x", "_y", "_z"}) columns.push_back(name + axis);
}

}  // namespace

std::vector<std::string> makeRunColumns(const RobotModel& robot) {
  std::vector<std::string> columns = {"t"};
  for (const EffectorDescription& effector : robot.description().effectors) {
    addPoint("target_" + effector.name, columns);
    addPoint("effector_" + effector.name, columns);
  }
  for (const ActuatorLimits& actuator : robot.actuators()) {
    columns.push_back("displacement_" + actuator.name);
    columns.push_back("effort_" + actuator.name);
  }
  columns.insert(columns.end(), {"status", "residual", "contacts"});
  return columns;
}

void refuseUnknownColumns(const CsvTable& table, const RobotModel& robot) {
  const std::vector<std::string> known = makeRunColumns(robot);
  for (const std::string& column : table.columns()) {
    if (std::find(known.begin(), known.end(), column) != known.end()) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    throw ConfigError(table.name(), "column " + column, "any of " + names);
  }
}

RunWriter::RunWriter(const std::string& path, const RobotModel& robot) : path_(path), file_(path) {
  const char* separator = "";
  for (const std::string& column : makeRunColumns(robot)) {
    file_ << separator << column;
    separator = ",";
  }
  file_ << "\n";
  if (!file_) fail();
}

void RunWriter::write(const RunRow& row) {
  file_ << formatNumber(row.time);
  for (Eigen::Index e = 0; e < row.effectors.size(); e += 3) {
    writeNumbers(row.targets.segment<3>(e));
    writeNumbers(row.effectors.segment<3>(e));
  }
  for (Eigen::Index i = 0; i < row.displacement.size(); ++i) {
    file_ << "," << formatNumber(row.displacement[i]) << "," << formatNumber(row.effort[i]);
  }
  file_ << "," << row.status << "," << formatNumber(row.residual) << "," << row.contacts << "\n";
}

void RunWriter::close() {
  file_.close();
  if (!file_) fail();
}

void RunWriter::writeNumbers(const VecX& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) file_ << "," << formatNumber(values[i]);
}

void RunWriter::fail() const {
  throw ConfigError(path_, "a file that cannot be written", "a path that can");
}

RunProgress::RunProgress(int rows) : rows_(std::max(rows, 1)), terminal_(isatty(STDERR_FILENO) == 1) {}

RunProgress::~RunProgress() {
  if (terminal_ && shown_ >= 0) std::fputs("\r      \r", stderr);
}

void RunProgress::update(int done) {
  const int percent = static_cast<int>(100.0 * done / rows_);
  if (!terminal_ || percent == shown_) return;
  shown_ = percent;
  std::fprintf(stderr, "\r%3d %%", percent);
  std::fflush(stderr);
}

int countPressing(const Eigen::Ref<const VecX>& force) {
  return static_cast<int>((force.array() > 0).count());
}

int countCycles(double begin, double end, double rate) {
  constexpr double kRounding = 1e-6;  // of a cycle
  return 1 + static_cast<int>(std::floor((end - begin) * rate + kRounding));
}

}  // namespace sinew
