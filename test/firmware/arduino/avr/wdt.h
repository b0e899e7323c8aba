#pragma once

#include "firmware/arduino/Arduino.h"

constexpr int WDTO_120MS = 3;
inline void wdt_enable(int) {
  fake_arduino.watched = true;
}
inline void wdt_reset() {}
