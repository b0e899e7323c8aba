#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "sinew/inverse/inverse_controller.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {

/// Writes the contact problems of a run as text, see `writeQpccRecord`. The path is that of a search of its own, from
/// the same guess with the same counts.
class ContactRecorder {
 public:
  /// Throws ConfigError when `path` cannot be written.
  ContactRecorder(const std::string& path, const RobotModel& robot);

  /// The problem of the controller's last cycle, if that searched among contacts.
  void record(int cycle, double time, const InverseController& controller, const CycleOutput& output);

  /// Throws ConfigError when something could not be written.
  void close();
  int records() const { return records_; }

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  std::ofstream file_;
  std::vector<std::string> names_;
  QpccBudget budget_;
  std::vector<QpccVisit> visits_;
  int records_ = 0;
};

}  // namespace sinew
