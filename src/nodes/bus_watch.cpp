#include <unistd.h>

#include <cstdio>
#include <limits>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"

namespace sinew {
namespace {

/// The table of readings, written over itself at a terminal.
class ReadingTable {
 public:
  explicit ReadingTable(const HardwareDescription& hardware)
      : names_(hardware.names()), quantities_(hardware.quantities()), width_(calcWidth(names_)) {}

  void print(const DriverReport& report) {
    if (drawn_ && isatty(STDOUT_FILENO) != 0) std::printf("\033[%zuA", names_.size() + 2);
    drawn_ = true;
    printLine(makeReadingHeader(width_));
    for (std::size_t i = 0; i < names_.size(); ++i)
      printLine(makeReadingRow(names_[i], width_, quantities_[i], report.actuators[i]));
    printLine(std::string(name(report.state)) + ": " + report.reason +
              (report.emergency_stop ? "; the emergency stop is pressed, or its device cannot be read" : ""));
    std::fflush(stdout);
  }

 private:
  static void printLine(const std::string& line) {
    std::printf("%s%s\n", line.c_str(), isatty(STDOUT_FILENO) != 0 ? "\033[K" : "");
  }

  std::vector<std::string> names_;
  std::vector<Quantity> quantities_;
  int width_;
  bool drawn_ = false;
};

}  // namespace

int watch(HardwareDescription hardware, const WatchOrder& order) {
  homeWhereFound(hardware);
  if (!isAllowed("Every device is switched on where it stands, and let go at the end. Nothing is to move. "
                 "Cables\ncount from where they are found.",
                 order.yes))
    return kDone;
  BusSession session(hardware);
  const bool ready = session.setUp();
  ReadingTable table(hardware);
  const Time begin = Clock::now();
  const Time end = order.seconds > 0 ? begin + duration(order.seconds) : Time::max();
  Time next = begin;
  while (ready && !isStopAsked() && Clock::now() < end) {
    session.cycle();
    if (Clock::now() < next) continue;
    next += duration(1 / order.rate);
    table.print(session.report());
  }
  const bool well = session.report().state == DriverState::kReady || (!ready && isStopAsked());
  table.print(session.report());
  std::printf("letting go\n");
  session.letGo();
  return well ? kDone : kNotWell;
}

}  // namespace sinew
