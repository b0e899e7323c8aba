#include "stage_samples.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "measuring.h"
#include "sinew/fem/fem_model.h"
#include "sinew/linalg/instruction_set.h"

namespace sinew {

void ContactCounts::add(const ContactReport& contacts) {
  all.push_back(contacts.count);
  pressing.push_back(static_cast<int>((contacts.force.head(contacts.count).array() > 0).count()));
}

void printStage(const std::string& scene, const RobotModel& robot, const std::string& stage,
                const DurationSample& sample, const ContactCounts& contacts, double thesis) {
  const int most = contacts.all.empty() ? 0 : *std::max_element(contacts.all.begin(), contacts.all.end());
  std::printf(
      "scene=%s dofs=%d rows=%d contacts=%d contacts_max=%d pressing=%d threads=1 isa=%s stage=%s median_ms=%.3f "
      "p99_ms=%.3f max_ms=%.3f thesis_ms=%.2f",
      scene.c_str(), robot.fem().size(), robot.actuatorCount() + robot.effectorRows(), calcMedian(contacts.all), most,
      calcMedian(contacts.pressing), nameOf(chooseInstructionSet()), stage.c_str(), 1e3 * sample.calcQuantile(0.5),
      1e3 * sample.calcQuantile(0.99), 1e3 * sample.calcQuantile(1), thesis);
}

void StageSamples::add(const CycleOutput& output) {
  assembly_.add(output.times.assembly);
  factor_.add(output.times.factor);
  detection_.add(output.times.detection);
  compliance_.add(output.times.compliance);
  qp_.add(output.times.qp);
  advance_.add(output.times.advance);
  cycle_.add(output.times.cycle);
  contacts_.add(output.contacts);
  ++cycles_;
  held_ += output.status == CycleStatus::kHeld;
  proved_ += output.contacts.count == 0 || output.contacts.proved_global;
}

void StageSamples::print(const std::string& scene, const RobotModel& robot,
                         const std::map<std::string, double>& thesis) const {
  const std::vector<std::pair<std::string, const DurationSample*>> stages = {{"assembly", &assembly_},
                                                                             {"factor", &factor_},
                                                                             {"detection", &detection_},
                                                                             {"compliance", &compliance_},
                                                                             {"qp", &qp_},
                                                                             {"advance", &advance_},
                                                                             {"cycle", &cycle_}};
  for (const auto& [stage, sample] : stages) {
    const auto figure = thesis.find(stage);
    printStage(scene, robot, stage, *sample, contacts_,
               figure == thesis.end() ? std::numeric_limits<double>::quiet_NaN() : figure->second);
    if (stage == "qp") std::printf(" proved_percent=%.1f", 100.0 * proved_ / std::max(1, cycles_));
    if (stage == "cycle") std::printf(" held=%d", held_);
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace sinew
