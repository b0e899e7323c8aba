#include "simulate_contacts.h"

#include "sinew/common/config_error.h"
#include "sinew/inverse/contact_search.h"
#include "sinew/solver/qpcc_record.h"

namespace sinew {

ContactRecorder::ContactRecorder(const std::string& path, const RobotModel& robot) : path_(path), file_(path) {
  if (!file_) fail();
  for (const ActuatorLimits& actuator : listActuators(robot.description())) names_.push_back(actuator.name);
  budget_.max_pieces = robot.description().control.max_pieces;
  budget_.max_nodes = robot.description().control.max_nodes;
}

void ContactRecorder::record(int cycle, double time, const InverseController& controller, const CycleOutput& output) {
  const bool searched = output.status != CycleStatus::kHeld || output.reason == HoldReason::kQpFailed;
  if (output.contacts.count == 0 || output.contacts.pieces == 0 || !searched) return;
  const ContactSearch& search = controller.contactSearch();
  QpccSolver solver(search.problem().size);
  QpccSolution scratch(search.problem().size);
  solver.watch(&visits_);
  solver.solve(search.problem(), search.guess(), budget_, scratch);
  writeQpccRecord(file_, {cycle, time, names_, search.problem(), search.guess(), search.solution(), visits_});
  ++records_;
}

void ContactRecorder::close() {
  file_.close();
  if (!file_) fail();
}

void ContactRecorder::fail() const {
  throw ConfigError(path_, "a file that cannot be written", "a path that can");
}

}  // namespace sinew
