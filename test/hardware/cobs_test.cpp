#include "sinew/hardware/cobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encode(const Bytes& data) {
  Bytes out;
  appendCobs(data.data(), data.size(), out);
  return out;
}

Bytes run(int first, int last) {
  Bytes bytes(static_cast<std::size_t>(last - first + 1));
  std::iota(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(first));
  return bytes;
}

Bytes join(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// "Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on Networking 7(2), 1999, section III: a code byte n below
// 0xFF stands for n - 1 bytes and a zero, 0xFF for 254 bytes without one; the zero that the packet's end would add is
// left out.
TEST(Cobs, BlocksAsThePaperDefinesThem) {
  EXPECT_EQ(encode({}), (Bytes{1}));
  EXPECT_EQ(encode({0}), (Bytes{1, 1}));
  EXPECT_EQ(encode({0, 0}), (Bytes{1, 1, 1}));
  EXPECT_EQ(encode({0x11, 0x22, 0, 0x33}), (Bytes{3, 0x11, 0x22, 2, 0x33}));
  EXPECT_EQ(encode({0x11, 0, 0, 0}), (Bytes{2, 0x11, 1, 1, 1}));
  EXPECT_EQ(encode(run(1, 254)), join({0xFF}, run(1, 254)));
  EXPECT_EQ(encode(run(0, 254)), join({1, 0xFF}, run(1, 254)));
  EXPECT_EQ(encode(run(1, 255)), join(join({0xFF}, run(1, 254)), {2, 0xFF}));
  EXPECT_EQ(encode(join(run(2, 255), {0})), join(join({0xFF}, run(2, 255)), {1, 1}));
  EXPECT_EQ(encode(join(run(3, 255), {0, 1})), join(join({0xFE}, run(3, 255)), {2, 1}));
}

TEST(Cobs, EverythingComesBack) {
  std::mt19937 random(11);
  Bytes back;
  for (std::size_t size = 0; size < 900; size += 1 + size / 40) {
    for (const unsigned range : {2u, 20u, 256u, 100000u}) {
      Bytes data(size);
      for (std::uint8_t& b : data) b = static_cast<std::uint8_t>(std::min(random() % range, 255ul));
      const Bytes stuffed = encode(data);
      EXPECT_EQ(std::count(stuffed.begin(), stuffed.end(), 0), 0);
      EXPECT_LE(stuffed.size(), size + size / 254 + 1);
      ASSERT_TRUE(decodeCobs(stuffed.data(), stuffed.size(), back));
      EXPECT_EQ(back, data);
    }
  }
}

TEST(Cobs, RefusesWhatNoDataGive) {
  Bytes out;
  for (const Bytes& broken :
       {Bytes{}, Bytes{0}, Bytes{2}, Bytes{5, 1, 2, 3}, Bytes{3, 1, 0}, Bytes{1, 0}, Bytes{2, 1, 9}})
    EXPECT_FALSE(decodeCobs(broken.data(), broken.size(), out));
}

}  // namespace
}  // namespace sinew
