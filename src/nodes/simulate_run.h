#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "sinew/common/csv_table.h"
#include "sinew/common/types.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

/// One row of a run, in SI units; three coordinates an effector, one value an actuator.
struct RunRow {
  double time = 0;      ///< s
  VecX targets;         ///< m, NaN where an effector has none
  VecX effectors;       ///< m
  VecX displacement;    ///< m
  VecX effort;          ///< N
  std::string status;   ///< ok, degraded, held; of the forward problem ok, not_converged, failed
  double residual = 0;  ///< N, norm of the unbalanced nodal forces
  int contacts = 0;     ///< 1, that press
};

/// Rows done so far and how they went.
struct RunSummary {
  int rows = 0;
  int not_ok = 0;
  double mean_error = 0;  ///< m, mean distance of the targeted effectors to their targets; 0 without targets
};

/// Names of a run's columns: t, target_NAME_x .. z and effector_NAME_x .. z per effector, displacement_NAME and
/// effort_NAME per actuator, status, residual, contacts.
std::vector<std::string> makeRunColumns(const RobotModel& robot);

/// Throws ConfigError for a column that no run of `robot` has.
void refuseUnknownColumns(const CsvTable& table, const RobotModel& robot);

/// Writes a run row by row as a text table. Numbers are the shortest that read back as the same double.
class RunWriter {
 public:
  /// Throws ConfigError when `path` cannot be written.
  RunWriter(const std::string& path, const RobotModel& robot);
  void write(const RunRow& row);
  /// Throws ConfigError when something could not be written.
  void close();

 private:
  void writeNumbers(const VecX& values);
  [[noreturn]] void fail() const;

  std::string path_;
  std::ofstream file_;
};

/// Percentage on the terminal, when standard error is one.
class RunProgress {
 public:
  explicit RunProgress(int rows);
  ~RunProgress();
  RunProgress(const RunProgress&) = delete;
  RunProgress& operator=(const RunProgress&) = delete;
  void update(int done);

 private:
  int rows_;
  int shown_ = -1;  // percent
  bool terminal_;
};

/// Contacts that press at all.
int countPressing(const Eigen::Ref<const VecX>& force);

/// Number of cycles of 1 / `rate` from `begin` to `end` [s], both included.
int countCycles(double begin, double end, double rate);

}  // namespace sinew
