#include "check_advice.h"

#include <algorithm>
#include <sstream>

namespace sinew {
namespace {

constexpr double kMatters = 0.15;  // of a cycle, below which nothing is said of it

struct Saving {
  double share;  // of a cycle
  std::string words;
};

std::string inPercent(double share) {
  std::ostringstream stream;
  stream << static_cast<int>(100 * share + 0.5) << " %";
  return stream.str();
}

std::string adviseOnRows(const CycleTiming& timing) {
  const std::string way = timing.contacts > 0
                              ? "fewer contacts (" + std::to_string(timing.contacts) +
                                    " at once): contacts.method: volume, a smaller alarm_distance or max_contacts"
                              : "fewer effectors, or fewer of their axes";
  return "compliance takes " + inPercent(timing.shareOf(CycleTiming::kCompliance)) + " of a cycle: fewer elements; " +
         way;
}

}  // namespace

std::vector<std::string> advise(const RobotDescription& robot, const CycleTiming& timing) {
  const double mesh = timing.shareOf(CycleTiming::kAssembly) + timing.shareOf(CycleTiming::kFactor);
  const double steps = 1 - 1.0 / robot.control.newton_steps;
  std::vector<Saving> savings = {
      {mesh, "assembly and factor take " + inPercent(mesh) + " of a cycle: fewer elements, that is a coarser mesh"},
      {timing.shareOf(CycleTiming::kCompliance), adviseOnRows(timing)},
      {timing.shareOf(CycleTiming::kDetection),
       "detection takes " + inPercent(timing.shareOf(CycleTiming::kDetection)) +
           " of a cycle: coarser meshes of obstacles, a smaller alarm_distance, self-contact of named regions only"},
      {timing.shareOf(CycleTiming::kQp),
       "the search among contacts takes " + inPercent(timing.shareOf(CycleTiming::kQp)) +
           " of a cycle: smaller control.max_pieces and max_nodes, or a control.search_time; fewer contacts"},
      {steps, "control.newton_steps: 1 would spare " + inPercent(steps) + " of a cycle"}};
  std::stable_sort(savings.begin(), savings.end(), [](const Saving& a, const Saving& b) { return a.share > b.share; });
  std::vector<std::string> advice;
  for (const Saving& saving : savings) {
    if (saving.share >= kMatters) advice.push_back(saving.words);
  }
  return advice;
}

}  // namespace sinew
