#include <stdlib.h>

#include <cstdio>
#include <fstream>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"
#include "duration_sample.h"

namespace sinew {
namespace {

constexpr double kUsedShare = 0.75;  // of a period; the rest is for the controller and for bad moments
constexpr double kMuch = 0.01;       // share of answers that are missing or damaged
constexpr int kGoodTimer = 1;        // ms

std::string resolve(const std::string& path) {
  char* const real = realpath(path.c_str(), nullptr);
  const std::string resolved = real != nullptr ? real : path;
  free(real);
  return resolved;
}

// Of an FTDI adapter: how long it waits for more bytes before it hands on what has come. -1 for any other.
int readLatencyTimer(const std::string& port) {
  const std::string device = resolve(port);
  std::ifstream file("/sys/bus/usb-serial/devices/" + device.substr(device.rfind('/') + 1) + "/latency_timer");
  int milliseconds = -1;
  return file >> milliseconds ? milliseconds : -1;
}

void printAdapter(const BusDescription& bus) {
  if (bus.isCanInterface()) return;
  const int timer = readLatencyTimer(bus.port);
  if (timer < 0) {
    std::printf("  adapter    no FTDI latency timer here\n");
  } else if (timer <= kGoodTimer) {
    std::printf("  adapter    hands bytes on after %d ms: as it should be\n", timer);
  } else {
    std::printf(
        "  adapter    keeps bytes back for %d ms: copy config/udev/99-sinew-serial.rules to /etc/udev/rules.d,\n"
        "             call 'sudo udevadm control --reload', and plug the adapter in again\n",
        timer);
  }
}

void printTimes(const DurationSample& times) {
  std::printf("  cycle      %zu times write and read: median %.2f ms, 99 %% within %.2f ms, worst %.2f ms\n",
              times.size(), 1e3 * times.calcQuantile(0.5), 1e3 * times.calcQuantile(0.99), 1e3 * times.calcQuantile(1));
}

void printLosses(const BusCounters& before, const BusCounters& after, std::size_t answers) {
  const std::uint64_t missing = after.missing - before.missing, damaged = after.corrupted - before.corrupted;
  std::printf("  answers    %llu missing and %llu damaged of %zu%s\n", static_cast<unsigned long long>(missing),
              static_cast<unsigned long long>(damaged), answers,
              static_cast<double>(missing + damaged) > kMuch * static_cast<double>(answers)
                  ? ": look at plugs, cable lengths, ground and supply"
                  : "");
}

/// Times a bus alone; s that 99 % of its cycles take, negative when a device is not well.
double measure(const HardwareDescription& hardware, int cycles) {
  const BusDescription& bus = hardware.buses.front();
  std::printf("bus %s at %s\n", bus.name.c_str(), bus.port.c_str());
  BusSession session(hardware);
  if (!session.setUp()) {
    std::printf("  %s\n", session.whyNot().c_str());
    return -1;
  }
  printAdapter(bus);
  std::fflush(stdout);
  const BusCounters before = session.report().bus;
  DurationSample times;
  for (int n = 0; n < cycles && !isStopAsked() && session.report().state == DriverState::kReady; ++n) {
    const Time begin = Clock::now();
    session.cycleNow();
    times.add(seconds(Clock::now() - begin));
  }
  if (session.report().state != DriverState::kReady || times.size() == 0) {
    std::printf("  %s\n", session.whyNot().c_str());
    return -1;
  }
  printTimes(times);
  printLosses(before, session.report().bus, times.size() * hardware.actuators.size());
  return times.calcQuantile(0.99);
}

}  // namespace

int measureLatency(HardwareDescription hardware, const LatencyOrder& order) {
  homeWhereFound(hardware);
  if (!isAllowed("Bus by bus, devices are switched on where they stand, asked as fast as they answer, and let go. "
                 "Nothing is to move.",
                 order.yes))
    return kDone;
  double cycle = 0;
  bool well = true;
  for (int bus = 0; bus < static_cast<int>(hardware.buses.size()) && !isStopAsked(); ++bus) {
    const double time = measure(select(hardware, hardware.actuatorsOn(bus)), order.cycles);
    well = well && time >= 0;
    cycle += time;
  }
  if (!well || isStopAsked()) return kNotWell;
  const double rate = kUsedShare / cycle;
  std::printf("all buses one after the other allow up to %.0f Hz, with a quarter of each period to spare%s\n", rate,
              rate < hardware.rate ? "" : "; the file's rate is within that");
  if (rate < hardware.rate)
    std::printf("the file asks for %.4g Hz: lower it, raise the baud rate, or share the devices among more buses\n",
                hardware.rate);
  return kDone;
}

}  // namespace sinew
