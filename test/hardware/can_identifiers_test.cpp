#include "sinew/hardware/can_identifiers.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr int kDriver = 127;

std::string complaint(int odrive, const std::vector<CanNodeNumber>& canopen) {
  try {
    refuseSharedIdentifiers({{"cable_1", odrive}}, canopen, kDriver);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

// ODrive documentation, "CAN Protocol", interoperability with CANopen: nodes 10 and 18 (hexadecimal) get on with
// CANopen nodes from 32 on, as those of 35 do not use 200 to 21F.
TEST(CanIdentifiers, TheExampleOfTheDocumentationIsFree) {
  EXPECT_EQ(complaint(0x10, {{"a", 35}}), "");
  EXPECT_EQ(complaint(0x18, {{"a", 35}}), "");
  EXPECT_NE(complaint(0x10, {{"a", 3}}), "") << "203 is its RPDO 1, and 0C of node 10 commands a position";
}

TEST(CanIdentifiers, WhatAllNodesHearIsTaken) {
  for (const int odrive : {0, 4, 8}) EXPECT_NE(complaint(odrive, {{"a", 35}}), "") << odrive;
  EXPECT_NE(complaint(59, {{"a", 35}}), "") << "77F is the driver's heartbeat";
}

TEST(CanIdentifiers, SaysWhatWouldBeFree) {
  const std::string words = complaint(17, {{"a", 35}});
  EXPECT_NE(words.find("cable_1.node"), std::string::npos) << words;
  EXPECT_NE(words.find("one of 1 2 3 6 7 "), std::string::npos) << words;
  EXPECT_EQ(words.find(" 17 "), std::string::npos) << words;
}

TEST(CanIdentifiers, ODrivesAmongThemselvesMayHaveAny) {
  for (int n = 0; n <= 62; ++n) EXPECT_EQ(complaint(n, {}), "") << n;
}

}  // namespace
}  // namespace sinew
