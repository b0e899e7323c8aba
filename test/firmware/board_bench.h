#pragma once

#include <sinew_board_link.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sinew {

/// A board's hardware for tests: chambers that fill and empty exponentially, stepped by the millisecond.
class BoardBench {
 public:
  static constexpr int kChannels = 2;
  struct Chamber {
    double pressure = 0;  // Pa gauge
    sinew_path path = SINEW_PATH_CLOSED;
    int duty = 0;
    bool broken = false;  // its sensor
    double highest = 0;   // Pa gauge, since the start
  };

  BoardBench() { restart(); }
  BoardBench(const BoardBench&) = delete;
  BoardBench& operator=(const BoardBench&) = delete;

  void restart() {
    const sinew_board_settings s = settings();
    const sinew_hardware h = hardware();
    sinew_board_start(&board, &s, &h);
  }

  static sinew_board_settings settings() {
    sinew_board_settings s{};
    s.identity.firmware_major = 1;
    s.identity.channels = kChannels;
    s.identity.range_min = -50000;
    s.identity.range_max = 200000;
    s.hysteresis = 200;
    s.proportional_band = 2500;
    s.least_duty = 8;
    s.supply_min = 10000;
    s.supply_max = 14000;
    s.temperature_max = 700;
    s.source_low = 220000;
    s.source_high = 250000;
    s.source_time = 1000;
    return s;
  }

  /// Lets `ms` pass, a look at the sensors each.
  void pass(int ms) {
    for (int n = 0; n < ms; ++n) {
      ++now;
      sinew_board_update(&board);
      for (Chamber& c : chambers) flow(c);
    }
  }

  static sinew_configuration makeConfiguration() {
    sinew_configuration c{};
    c.timeout = 100;
    c.count = kChannels;
    for (int i = 0; i < kChannels; ++i) c.channels[i] = {100000, 200000, SINEW_VENT};
    return c;
  }

  static sinew_set_point regulate(std::int32_t pressure, std::uint32_t ramp = 200000) {
    return {SINEW_REGULATE, pressure, 100000, ramp};
  }

  /// Offers one set point to every channel, as SET_POINTS does; returns the refusal.
  std::uint8_t command(const sinew_set_point& s) { return command(s, ++sequence); }
  std::uint8_t command(const sinew_set_point& s, std::uint16_t with) {
    sinew_request r{};
    r.type = SINEW_SET_POINTS;
    r.sequence = with;
    r.as.set_points.count = kChannels;
    for (int i = 0; i < kChannels; ++i) r.as.set_points.channels[i] = s;
    sinew_answer answer{};
    sinew_board_handle(&board, &r, SINEW_ACCEPTED, &answer);
    return answer.as.state.refusal;
  }

  /// Keeps a set point alive for `ms`.
  void hold(const sinew_set_point& s, int ms) {
    for (int n = 0; n < ms; n += 10) {
      command(s);
      pass(10);
    }
  }

  sinew_state state() const {
    sinew_state s{};
    sinew_board_get_state(&board, &s);
    return s;
  }
  int mode(int i) const { return board.channels[i].mode; }
  int faults(int i) const { return board.channels[i].faults; }

  sinew_board board{};
  Chamber chambers[kChannels];
  std::uint32_t now = 5;  // ms
  std::uint16_t sequence = 0;
  double tank = 240000;  // Pa gauge
  std::uint16_t supply = 12000;
  std::int16_t temperature = 250;
  bool stop = false, pump = false;
  double fill_rate = 5;  // 1/s of an open valve

 private:
  static BoardBench& of(void* context) { return *static_cast<BoardBench*>(context); }

  void flow(Chamber& c) const {
    const double source = c.path == SINEW_PATH_FILL ? tank : c.path == SINEW_PATH_EVACUATE ? -60000 : 0;
    const double share = c.path == SINEW_PATH_CLOSED ? 0 : c.duty / 255.;
    c.pressure = source + (c.pressure - source) * std::exp(-fill_rate * share * 1e-3);
    c.highest = std::max(c.highest, c.pressure);
  }

  sinew_hardware hardware() {
    sinew_hardware h{};
    h.context = this;
    h.millis = [](void* c) { return of(c).now; };
    h.pressure = [](void* c, std::uint8_t i) {
      const Chamber& chamber = of(c).chambers[i];
      return chamber.broken ? std::int32_t{600000} : static_cast<std::int32_t>(std::lround(chamber.pressure));
    };
    h.source_pressure = [](void* c) { return static_cast<std::int32_t>(of(c).tank); };
    h.supply = [](void* c) { return of(c).supply; };
    h.temperature = [](void* c) { return of(c).temperature; };
    h.emergency_stop = [](void* c) { return of(c).stop; };
    h.set_valves = [](void* c, std::uint8_t i, sinew_path path, std::uint8_t duty) {
      of(c).chambers[i].path = path;
      of(c).chambers[i].duty = duty;
    };
    h.set_pump = [](void* c, bool on) { of(c).pump = on; };
    return h;
  }
};

}  // namespace sinew
