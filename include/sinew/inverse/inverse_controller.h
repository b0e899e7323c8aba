#pragma once

#include <memory>
#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/inverse/cycle.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

class ContactSearch;

/// Finds, every cycle, the cable displacements that bring the effectors nearest to their targets, and among equal ones
/// those of least potential energy (thesis 3.3). The plan is quasi-static; in a dynamic robot a second body follows the
/// commands with inertia and damping, and is what the effectors and nodes report. The model integrates its own state.
class InverseController {
 public:
  explicit InverseController(std::shared_ptr<const RobotModel> robot);
  ~InverseController();

  const RobotModel& robot() const;
  CycleInput makeInput() const;
  CycleOutput makeOutput() const;

  /// Linearises and factorises ahead what the next `step` starts from, which is nearly all of its work and does not
  /// depend on its input, so that the command follows its targets without delay. Adds to the output's times.
  void prepare(CycleOutput& output);

  /// One control cycle, which leaves out what the input's overload level says. Never throws; on failure the output
  /// holds the last valid command with the reason.
  CycleStatus step(const CycleInput& input, CycleOutput& output);

  /// Where linearisations are shared, `step` answers again and again with the one that it has: the newest targets,
  /// limits and ways of known obstacles, with the compliance and the contacts of before. A new one is made beside the
  /// cycles: `beginRenewal` and `endRenewal` between two steps, `renew` on any thread in between. Adds to the times; a
  /// renewal that fails, or that the model has overtaken by other means, is dropped.
  void makeSpare();  ///< room for it, once before the first cycle
  void beginRenewal();
  void renew(StageTimes& times);
  void endRenewal();

  /// Moves the model to the measured displacements [m] by solving the forward problem, over as many load steps as it
  /// takes. Returns the largest remaining difference between measured and modelled displacement of a taut cable [m]
  /// or infinity when no equilibrium is found. Not for the cycle path.
  double resynchronise(const VecX& measured);

  /// Advances the model with the displacements [m] held, as `step` does where nothing is targeted. Not for the cycle
  /// path: it takes memory.
  CycleStatus follow(const VecX& displacement, double period, CycleOutput& output);

  /// Back to rest: no displacement, no effort.
  void reset();

  const std::vector<Vec3>& nodes() const;                            ///< m, present positions
  const ContactList& contacts() const;                               ///< of the last cycle, as found at its start
  const ContactSearch& contactSearch() const;                        ///< of the last cycle that had contacts
  void calcCablePoints(int cable, std::vector<Vec3>& points) const;  ///< m, pull point first

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
