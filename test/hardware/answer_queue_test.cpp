#include "sinew/hardware/answer_queue.h"

#include <gtest/gtest.h>

#include <bitset>

namespace sinew {
namespace {

using Bytes = AnswerQueue::Bytes;

const Time kStart{std::chrono::seconds(10)};

Bytes transmit(AnswerQueue& queue, Time now) {
  Bytes out(4000);
  out.resize(queue.transmit(out.data(), out.size(), now));
  return out;
}

TEST(AnswerQueue, FramesTakeTheirTimeOnTheLineOneAfterTheOther) {
  AnswerQueue queue(10000);  // a byte a millisecond
  const Time heard = queue.occupy(5, kStart);
  EXPECT_EQ(heard, kStart + duration(0.005));
  queue.send(Bytes(3, 1), heard + duration(0.001));
  queue.send(Bytes(2, 2), heard);
  EXPECT_EQ(queue.nextDue(), kStart + duration(0.009));
  EXPECT_TRUE(transmit(queue, kStart + duration(0.0089)).empty());
  EXPECT_EQ(transmit(queue, kStart + duration(0.009)), Bytes(3, 1));
  EXPECT_EQ(queue.nextDue(), kStart + duration(0.011));
  EXPECT_EQ(transmit(queue, kStart + duration(1)), Bytes(2, 2));
  EXPECT_EQ(queue.nextDue(), Time::max());
}

TEST(AnswerQueue, SendsWholeFramesOnly) {
  AnswerQueue queue(1000000);
  queue.send(Bytes(10, 1), kStart);
  std::uint8_t data[9];
  EXPECT_EQ(queue.transmit(data, sizeof data, kStart + duration(1)), 0u);
}

TEST(AnswerQueue, FaultsComeAsOftenAsAskedAndAreCounted) {
  AnswerQueue queue(1000000);
  LineFaults faults;
  faults.corrupt = 0.1;
  faults.drop = 0.05;
  faults.delay = 0.2;
  faults.duplicate = 0.15;
  faults.seed = 3;
  queue.setFaults(faults);
  const Bytes good{0x55, 0xAA, 0x00, 0xFF};
  std::uint64_t none = 0, twice = 0, damaged = 0, late = 0;
  for (int n = 0; n < 20000; ++n) {
    const Time at = kStart + n * std::chrono::seconds(1);
    queue.send(good, at);
    late += queue.nextDue() != Time::max() && queue.nextDue() > at + duration(0.015) ? 1 : 0;
    const Bytes got = transmit(queue, at + duration(0.5));
    none += got.empty() ? 1 : 0;
    twice += got.size() == 8 ? 1 : 0;
    if (got.size() != 4 || got == good) continue;
    ++damaged;
    std::size_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i) bits += std::bitset<8>(got[i] ^ good[i]).count();
    EXPECT_LE(bits, 3u);
  }
  const LineFaultCounts& counts = queue.counts();
  EXPECT_EQ(counts.dropped, none);
  EXPECT_EQ(counts.duplicated, twice);
  EXPECT_EQ(counts.corrupted, damaged);
  EXPECT_EQ(counts.delayed, late);
  EXPECT_EQ(counts.sent + counts.dropped + counts.duplicated + counts.corrupted + counts.delayed, 20000u);
  EXPECT_NEAR(static_cast<double>(counts.corrupted), 2000, 200);
  EXPECT_NEAR(static_cast<double>(counts.dropped), 1000, 150);
  EXPECT_NEAR(static_cast<double>(counts.delayed), 4000, 250);
  EXPECT_NEAR(static_cast<double>(counts.duplicated), 3000, 250);
}

}  // namespace
}  // namespace sinew
