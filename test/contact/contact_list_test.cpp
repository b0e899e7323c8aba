#include "sinew/contact/contact_list.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

ContactRow makeRow(std::uint64_t key, double gap) {
  ContactRow row;
  row.key = key;
  row.gap = gap;
  row.point = Vec3(static_cast<double>(key), 0, 0);
  return row;
}

void add(ContactList& list, std::uint64_t key, double gap, int entries) {
  std::vector<ContactEntry> values;
  for (int i = 0; i < entries; ++i) values.push_back({0, static_cast<int>(key), Vec3::Constant(gap)});
  list.add(makeRow(key, gap), values.data(), entries);
}

TEST(ContactList, SortsByKeyAndKeepsEntriesWithTheirRows) {
  ContactList list(10, 100);
  list.begin();
  for (const int key : {5, 2, 9, 1}) add(list, key, key, key);
  list.finish();
  ASSERT_EQ(list.size(), 4);
  const std::uint64_t expected[] = {1, 2, 5, 9};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(list.row(i).key, expected[i]);
    EXPECT_EQ(list.row(i).entries, static_cast<int>(expected[i]));
    for (int k = 0; k < list.row(i).entries; ++k) EXPECT_EQ(list.entries(i)[k].node, static_cast<int>(expected[i]));
  }
}

TEST(ContactList, KeepsTheClosestWhenFullAndSaysHowManyItDropped) {
  ContactList list(3, 7);
  list.begin();
  add(list, 1, 0.5, 2);
  add(list, 2, 0.1, 2);
  add(list, 3, 0.3, 2);
  add(list, 4, 0.2, 3);
  add(list, 5, 0.9, 1);
  list.finish();
  EXPECT_EQ(list.dropped(), 2);
  ASSERT_EQ(list.size(), 3);
  const std::uint64_t expected[] = {2, 3, 4};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(list.row(i).key, expected[i]);
    for (int k = 0; k < list.row(i).entries; ++k) EXPECT_EQ(list.entries(i)[k].node, static_cast<int>(expected[i]));
  }
  list.begin();
  EXPECT_EQ(list.dropped(), 0);
}

TEST(ContactList, RemembersTheCycleBefore) {
  ContactList list(10, 100);
  list.begin();
  add(list, 7, 0, 1);
  list.finish();
  EXPECT_FALSE(list.hadRow(7));
  list.begin();
  EXPECT_TRUE(list.hadRow(7));
  EXPECT_FALSE(list.hadRow(8));
  list.finish();
  list.begin();
  EXPECT_FALSE(list.hadRow(7));
}

TEST(ContactList, OfCoincidingRowsKeepsTheOneThatWasThere) {
  ContactList list(10, 100);
  const auto addBoth = [&](bool first_too) {
    list.begin();
    for (const int key : {4, 6}) {
      if (key == 4 && !first_too) continue;
      ContactRow row = makeRow(static_cast<std::uint64_t>(key), 0);
      row.point.setZero();
      const ContactEntry entry = {0, key, Vec3::UnitX()};
      list.add(row, &entry, 1);
    }
    list.finish();
  };
  addBoth(true);
  ASSERT_EQ(list.size(), 1);
  EXPECT_EQ(list.row(0).key, 4u);
  addBoth(false);
  addBoth(true);
  ASSERT_EQ(list.size(), 1);
  EXPECT_EQ(list.row(0).key, 6u);
  EXPECT_EQ(list.entries(0)->node, 6);
}

TEST(ContactList, RefusesToHaveNoRoom) {
  EXPECT_THROW(ContactList(0, 10), ConfigError);
  EXPECT_THROW(ContactList(10, 5), ConfigError);
}

}  // namespace
}  // namespace sinew
