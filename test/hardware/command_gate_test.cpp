#include "sinew/hardware/command_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

using V = CommandVerdict;
using Names = std::vector<std::string>;

const Time kNow{std::chrono::seconds(5)};

Command read(const Names& names, const std::vector<std::uint8_t>& modes, const std::vector<double>& values,
             std::uint8_t status = 0) {
  return CommandReader({"a", "b"}, {Quantity::kDisplacement, Quantity::kDisplacement})
      .read(1, 1, status, names, modes, values, {}, kNow);
}

TEST(CommandReader, BringsValuesIntoTheDriversOrder) {
  const Command c = read({"b", "a"}, {0, 0}, {2, 1}, 2);
  EXPECT_EQ(c.defect, V::kAccepted);
  EXPECT_EQ(c.value[0], 1);
  EXPECT_EQ(c.value[1], 2);
  EXPECT_EQ(c.status, CommandStatus::kHeld);
}

TEST(CommandReader, RefusesTheWholeMessage) {
  EXPECT_EQ(read({"a"}, {0}, {1}).defect, V::kMalformed) << "one is missing";
  EXPECT_EQ(read({"a", "b", "c"}, {0, 0, 0}, {1, 2, 3}).defect, V::kMalformed);
  EXPECT_EQ(read({"a", "a"}, {0, 0}, {1, 2}).defect, V::kMalformed) << "duplicate";
  EXPECT_EQ(read({"a", "x"}, {0, 0}, {1, 2}).defect, V::kMalformed) << "unknown";
  EXPECT_EQ(read({"a", "b"}, {0}, {1, 2}).defect, V::kMalformed);
  EXPECT_EQ(read({"a", "b"}, {0, 0}, {1}).defect, V::kMalformed);
  EXPECT_EQ(read({"a", "b"}, {0, 1}, {1, 2}).defect, V::kMalformed) << "a tension for a displacement";
  EXPECT_EQ(read({"a", "b"}, {0, 0}, {1, 2}, 3).defect, V::kMalformed) << "no such status";
  EXPECT_EQ(read({"a", "b"}, {0, 0}, {1, std::nan("")}).defect, V::kNotFinite);
  EXPECT_EQ(read({"a", "b"}, {0, 0}, {std::numeric_limits<double>::infinity(), 2}).defect, V::kNotFinite);
  EXPECT_EQ(read({}, {}, {}).defect, V::kMalformed);
}

TEST(CommandReader, EachActuatorHasItsOwnQuantity) {
  const CommandReader reader({"cable", "chamber"}, {Quantity::kDisplacement, Quantity::kPressure});
  const Command c = reader.read(1, 1, 0, {"chamber", "cable"}, {2, 0}, {5e4, 0.01}, {}, kNow);
  EXPECT_EQ(c.defect, V::kAccepted);
  EXPECT_EQ(c.value[0], 0.01);
  EXPECT_EQ(c.value[1], 5e4);
  EXPECT_EQ(reader.read(1, 1, 0, {"chamber", "cable"}, {0, 0}, {5e4, 0.01}, {}, kNow).defect, V::kMalformed);
}

TEST(CommandReader, ExpectedEffortsAreForAllOrForNone) {
  const CommandReader reader({"a", "b"}, {Quantity::kDisplacement, Quantity::kDisplacement});
  EXPECT_TRUE(std::isnan(reader.read(1, 1, 0, {"a", "b"}, {0, 0}, {1, 2}, {}, kNow).effort[1]));
  EXPECT_EQ(reader.read(1, 1, 0, {"b", "a"}, {0, 0}, {1, 2}, {3, 4}, kNow).effort[1], 3);
  EXPECT_EQ(reader.read(1, 1, 0, {"a", "b"}, {0, 0}, {1, 2}, {3}, kNow).defect, V::kMalformed);
}

TEST(CommandReader, HasRoomForSoManyActuators) {
  EXPECT_THROW(CommandReader(Names(kMaxActuators + 1, "x"), std::vector<Quantity>(kMaxActuators + 1)), ConfigError);
}

Command make(std::uint32_t session, std::uint32_t sequence) {
  return CommandReader({"a"}, {Quantity::kDisplacement}).read(session, sequence, 0, {"a"}, {0}, {0}, {}, kNow);
}

TEST(CommandGate, LocksToTheFirstSessionUntilReleased) {
  CommandGate gate;
  EXPECT_EQ(gate.session(), 0u);
  EXPECT_EQ(gate.check(make(10, 1)), V::kAccepted);
  EXPECT_FALSE(gate.locked()) << "a look locks nothing";
  gate.accept(make(10, 1));
  EXPECT_EQ(gate.session(), 10u);
  EXPECT_EQ(gate.check(make(11, 2)), V::kSession);
  gate.release();
  EXPECT_EQ(gate.check(make(11, 1)), V::kAccepted);
}

TEST(CommandGate, SequenceMustRise) {
  CommandGate gate;
  gate.accept(make(1, 5));
  EXPECT_EQ(gate.check(make(1, 5)), V::kSequence);
  EXPECT_EQ(gate.check(make(1, 4)), V::kSequence);
  EXPECT_EQ(gate.check(make(1, 6)), V::kAccepted);
  EXPECT_EQ(gate.check(make(1, 900)), V::kAccepted) << "gaps are no matter";
}

TEST(CommandGate, SequenceRisesAcrossTheWrap) {
  CommandGate gate;
  gate.accept(make(1, 0xFFFFFFFFu));
  EXPECT_EQ(gate.check(make(1, 0)), V::kAccepted);
  EXPECT_EQ(gate.check(make(1, 0xFFFFFFFEu)), V::kSequence);
}

TEST(CommandGate, AgesByTheClockItIsGiven) {
  CommandGate gate;
  EXPECT_EQ(gate.age(kNow), -1);
  gate.accept(make(1, 1));
  EXPECT_DOUBLE_EQ(gate.age(kNow + std::chrono::milliseconds(250)), 0.25);
}

TEST(CommandGate, CountsByReason) {
  CommandGate gate;
  for (const V v :
       {V::kMalformed, V::kNotFinite, V::kNotFinite, V::kSession, V::kSequence, V::kState, V::kState, V::kState})
    gate.refuse(v);
  gate.accept(make(1, 1));
  EXPECT_EQ(gate.counters().malformed, 1u);
  EXPECT_EQ(gate.counters().not_finite, 2u);
  EXPECT_EQ(gate.counters().session, 1u);
  EXPECT_EQ(gate.counters().sequence, 1u);
  EXPECT_EQ(gate.counters().state, 3u);
  EXPECT_EQ(gate.counters().accepted, 1u);
}

}  // namespace
}  // namespace sinew
