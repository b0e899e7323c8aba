#pragma once

#include <map>
#include <string>
#include <vector>

#include "duration_sample.h"
#include "sinew/inverse/cycle.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

/// How many contacts there were, cycle by cycle.
struct ContactCounts {
  std::vector<int> all, pressing;

  void add(const ContactReport& contacts);
};

/// One line of the report, without its end. thesis [ms]: NaN where it has no such figure.
void printStage(const std::string& scene, const RobotModel& robot, const std::string& stage,
                const DurationSample& sample, const ContactCounts& contacts, double thesis);

/// What a controller's cycles took, by stage.
class StageSamples {
 public:
  void add(const CycleOutput& output);
  /// A line a stage; `thesis`: ms by stage.
  void print(const std::string& scene, const RobotModel& robot, const std::map<std::string, double>& thesis) const;

  const ContactCounts& contacts() const { return contacts_; }
  int held() const { return held_; }  ///< cycles without an answer

 private:
  DurationSample assembly_, factor_, detection_, compliance_, qp_, advance_, cycle_;
  ContactCounts contacts_;
  int cycles_ = 0, held_ = 0, proved_ = 0;
};

}  // namespace sinew
