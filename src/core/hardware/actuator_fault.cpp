#include "sinew/hardware/actuator_fault.h"

#include "sinew/hardware/actuator_reading.h"

namespace sinew {
namespace {

// What is told first of several: what explains the others.
constexpr struct {
  std::uint32_t fault;
  const char* words;
} kWords[] = {
    {kFaultSilent, "does not answer"},
    {kFaultUndervolted, "had its supply dip, so its zero may be lost"},
    {kFaultOverheated, "is overheated"},
    {kFaultOverload, "is overloaded"},
    {kFaultVoltage, "reports a wrong supply voltage"},
    {kFaultSensor, "reports a broken sensor"},
    {kFaultEncoder, "reports an encoder error"},
    {kFaultElectrical, "reports an electrical error"},
    {kFaultFollowing, "cannot follow its set point"},
    {kFaultDevice, "reports an error of its own"},
    {kFaultJumped, "jumped, so its zero is lost"},
    {kFaultWatchdog, "was stopped by its own watchdog"},
    {kFaultOff, "is off: it restarted or shut down"},
    {kFaultDifference, "does not do what it is told: is it stuck, has its cable snapped, does it leak?"},
    {kFaultHot, "is hotter than the driver allows"},
    {kFaultCurrent, "draws more current than the driver allows"},
    {kFaultPressure, "has more pressure than the driver allows"},
};

}  // namespace

const char* describeFault(std::uint32_t fault) {
  for (const auto& w : kWords)
    if ((fault & w.fault) != 0) return w.words;
  return fault == 0 ? "is well" : "reports an unknown error";
}

}  // namespace sinew
