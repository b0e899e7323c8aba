#include "sinew/hardware/cobs.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr std::uint8_t kFull = 0xFF;  // a block of 254 bytes that no zero follows

}  // namespace

void appendCobs(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& out) {
  std::size_t start = out.size();  // of the block that is being filled
  out.push_back(1);
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] != 0) {
      out.push_back(data[i]);
      ++out[start];
    }
    const bool full = out[start] == kFull && i + 1 < size;
    if (data[i] != 0 && !full) continue;
    start = out.size();
    out.push_back(1);
  }
}

bool decodeCobs(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& out) {
  out.clear();
  const std::uint8_t* end = data + size;
  while (data != end) {
    const std::uint8_t code = *data;
    if (code == 0 || code > end - data) return false;
    const std::uint8_t* next = data + code;
    if (std::find(data, next, 0) != next) return false;
    out.insert(out.end(), data + 1, next);
    data = next;
    if (code != kFull && data != end) out.push_back(0);
  }
  return size > 0;
}

}  // namespace sinew
