#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "sinew/hardware/cobs.h"

namespace {

using Bytes = std::vector<std::uint8_t>;

void require(bool property) {
  if (!property) std::abort();
}

// What decodes has a shortest form that decodes to the same.
void checkDecoding(const Bytes& stuffed) {
  Bytes plain, again, back;
  if (!sinew::decodeCobs(stuffed.data(), stuffed.size(), plain)) return;
  require(plain.size() < stuffed.size());
  sinew::appendCobs(plain.data(), plain.size(), again);
  require(again.size() <= stuffed.size());
  require(sinew::decodeCobs(again.data(), again.size(), back) && back == plain);
}

void checkEncoding(const Bytes& plain) {
  Bytes stuffed, back;
  sinew::appendCobs(plain.data(), plain.size(), stuffed);
  require(stuffed.size() <= plain.size() + plain.size() / 254 + 1);
  require(std::count(stuffed.begin(), stuffed.end(), 0) == 0);
  require(sinew::decodeCobs(stuffed.data(), stuffed.size(), back) && back == plain);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, data + size);
  checkDecoding(bytes);
  checkEncoding(bytes);
  return 0;
}
