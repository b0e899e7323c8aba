#pragma once

#include <algorithm>
#include <initializer_list>
#include <random>

#include "sinew/hardware/can_frame.h"

namespace sinew {

inline CanFrame makeFrame(std::uint32_t id, std::initializer_list<int> data) {
  CanFrame frame;
  frame.id = id;
  for (const int byte : data) frame.data[frame.size++] = static_cast<std::uint8_t>(byte);
  return frame;
}

inline CanFrame makeExtended(std::uint32_t id, std::initializer_list<int> data) {
  CanFrame frame = makeFrame(id, data);
  frame.extended = true;
  return frame;
}

inline CanFrame makeRemote(std::uint32_t id, std::uint8_t size) {
  CanFrame frame;
  frame.id = id;
  frame.remote = true;
  frame.size = size;
  return frame;
}

inline CanFrame makeRandomFrame(std::mt19937& random) {
  CanFrame frame;
  frame.extended = random() % 2 == 0;
  frame.remote = random() % 4 == 0;
  frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFu : 0x7FFu);
  frame.size = static_cast<std::uint8_t>(random() % 9);
  for (std::size_t i = 0; i < frame.size && !frame.remote; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
  return frame;
}

inline bool operator==(const CanFrame& a, const CanFrame& b) {
  return a.id == b.id && a.extended == b.extended && a.remote == b.remote && a.size == b.size && a.data == b.data;
}

}  // namespace sinew
