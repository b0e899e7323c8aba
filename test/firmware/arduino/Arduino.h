#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

// As much of an Arduino as the sketch asks for, in the test's hand.

constexpr std::uint8_t A0 = 54, A1 = 55, A2 = 56, A3 = 57;
constexpr int LOW = 0, HIGH = 1, OUTPUT = 1, INPUT_PULLUP = 2;

struct FakeArduino {
  std::map<int, int> analog;   ///< counts that a pin reads
  std::map<int, int> digital;  ///< level that a pin reads; HIGH when nothing pulls it down
  std::map<int, int> written;  ///< level or duty of an output
  std::map<int, int> modes;
  std::uint32_t now = 0;  ///< ms
  bool watched = false;
};
inline FakeArduino fake_arduino;

inline int analogRead(std::uint8_t pin) {
  return fake_arduino.analog[pin];
}
inline void analogWrite(std::uint8_t pin, int duty) {
  fake_arduino.written[pin] = duty;
}
inline int digitalRead(std::uint8_t pin) {
  return fake_arduino.digital.count(pin) != 0 ? fake_arduino.digital[pin] : HIGH;
}
inline void digitalWrite(std::uint8_t pin, int level) {
  fake_arduino.written[pin] = level;
}
inline void pinMode(std::uint8_t pin, int mode) {
  fake_arduino.modes[pin] = mode;
}
inline std::uint32_t millis() {
  return fake_arduino.now;
}

struct FakeSerial {
  std::deque<std::uint8_t> in;
  std::vector<std::uint8_t> out;
  unsigned long baud = 0;

  void begin(unsigned long b) { baud = b; }
  int available() const { return static_cast<int>(in.size()); }
  int read() {
    const int byte = in.front();
    in.pop_front();
    return byte;
  }
  void write(const std::uint8_t* data, std::size_t size) { out.insert(out.end(), data, data + size); }
  void flush() {}
};
inline FakeSerial Serial;
