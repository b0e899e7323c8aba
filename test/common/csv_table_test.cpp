#include "sinew/common/csv_table.h"

#include <gtest/gtest.h>

#include <string>

#include "common/complaint.h"

namespace sinew {
namespace {

CsvTable readText(const std::string& text) {
  return CsvTable::fromText(text, "table.csv");
}

std::string complaintOfText(const std::string& text) {
  return complaintOf([&] { readText(text).risingNumbers("t"); });
}

TEST(CsvTable, ReadsNumbersByTheNameOfTheirColumn) {
  const CsvTable table = readText("t, b ,status\n0,1.5,ok\n1,-2e-3,held\n");
  EXPECT_EQ(table.columns(), (std::vector<std::string>{"t", "b", "status"}));
  EXPECT_EQ(table.rows(), 2);
  EXPECT_TRUE(table.has("status"));
  EXPECT_FALSE(table.has("c"));
  EXPECT_EQ(table.numbers("b"), Eigen::Vector2d(1.5, -2e-3));
}

TEST(CsvTable, TakesWhatSpreadsheetsWrite) {
  const CsvTable table = readText("\xEF\xBB\xBFt,b\r\n0,1\r\n\r\n1,2\r\n");
  EXPECT_EQ(table.numbers("t"), Eigen::Vector2d(0, 1));
  EXPECT_EQ(table.numbers("b"), Eigen::Vector2d(1, 2));
}

TEST(CsvTable, LeavesTextAloneUntilItIsAskedForAsANumber) {
  const CsvTable table = readText("t,status\n0,ok\n");
  const std::string complaint = complaintOf([&] { table.numbers("status"); });
  EXPECT_EQ(complaint, "table.csv:2: status: found ok, expected a finite number");
}

TEST(CsvTable, RefusesWhatIsNoFiniteNumber) {
  for (const char* cell : {"nan", "inf", "-inf", "", "1.5x", "1 2", "1e999"}) {
    const std::string complaint = complaintOfText(std::string("t,b\n0,0\n\n") + cell + ",0\n");
    EXPECT_EQ(complaint.find("table.csv:4: t: found "), 0U) << cell << ": " << complaint;
  }
}

TEST(CsvTable, RefusesTimesThatDoNotRise) {
  EXPECT_NE(complaintOfText("t\n0\n0\n").find("table.csv:3: t: found 0 after 0"), std::string::npos);
  EXPECT_NE(complaintOfText("t\n1\n2\n1.5\n").find("table.csv:4: t: found 1.5 after 2"), std::string::npos);
  EXPECT_EQ(complaintOfText("t\n-1\n2\n"), "");
}

TEST(CsvTable, RefusesAWrongShape) {
  EXPECT_NE(complaintOfText("").find("a line of column names"), std::string::npos);
  EXPECT_NE(complaintOfText("t,b\n").find("at least one row"), std::string::npos);
  EXPECT_NE(complaintOfText("t,t\n0,0\n").find("column t twice"), std::string::npos);
  EXPECT_NE(complaintOfText("t,\n0,0\n").find("a column without a name"), std::string::npos);
  EXPECT_NE(complaintOfText("t,b\n0\n").find("table.csv:2: found 1 cells, expected 2"), std::string::npos);
  EXPECT_NE(complaintOfText("b\n0\n").find("no column t"), std::string::npos);
}

TEST(CsvTable, NamesAFileThatIsNotThere) {
  EXPECT_NE(complaintOf([] { CsvTable::fromFile("no/such/table.csv"); }).find("no/such/table.csv"), std::string::npos);
}

}  // namespace
}  // namespace sinew
