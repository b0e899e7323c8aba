#include "sinew/mesh/file_cursor.h"

#include <gtest/gtest.h>

#include <clocale>

#include "mesh/mesh_files.h"

namespace sinew {
namespace {

TEST(FileCursor, ReadsWordsNumbersAndLines) {
  const TempFolder folder;
  FileCursor file(folder.write("a.txt", "first -12\r\n  3.5e-3 rest of it \r\n\r\nlast"));
  EXPECT_EQ(file.readWord("a word"), "first");
  EXPECT_TRUE(file.hasWordOnLine());
  EXPECT_EQ(file.readInteger("a number"), -12);
  EXPECT_FALSE(file.hasWordOnLine());
  EXPECT_DOUBLE_EQ(file.readReal("a number"), 3.5e-3);
  EXPECT_EQ(file.readLine(), " rest of it ");
  EXPECT_EQ(file.readLine(), "");
  EXPECT_FALSE(file.isAtEnd());
  file.expectWord("last");
  EXPECT_TRUE(file.isAtEnd());
}

TEST(FileCursor, ReadsBinaryNumbersInBothByteOrders) {
  const TempFolder folder;
  FileCursor file(folder.write("a.bin", std::string("\x01\x02\x02\x01", 4)));
  const auto first = file.readBinary<std::uint16_t>(isLittleEndian(), "a number");
  const auto second = file.readBinary<std::uint16_t>(!isLittleEndian(), "a number");
  EXPECT_EQ(first, 0x0102);
  EXPECT_EQ(second, 0x0102);
}

TEST(FileCursor, NamesTheLineOfATextFile) {
  const TempFolder folder;
  FileCursor file(folder.write("a.txt", "one\n\ntwo x12\n"));
  file.expectWord("one");
  file.expectWord("two");
  expectConfigError([&] { file.readInteger("a node index"); }, {"a.txt, line 3", "'x12'", "an integer: a node index"});
  expectConfigError([&] { file.readReal("a length"); }, {"line 4", "the end of the file", "a length"});
}

TEST(FileCursor, NamesTheByteOfABinaryFile) {
  const TempFolder folder;
  FileCursor file(folder.write("a.bin", "12345\n7"));
  file.readBinary<char>(false, "a byte");
  expectConfigError([&] { file.readBinary<double>(false, "a length"); }, {"a.bin, byte 1", "the end of the file"});
}

TEST(FileCursor, RefusesNumbersWithATail) {
  const TempFolder folder;
  FileCursor file(folder.write("a.txt", "1.5mm 3.0 99999999999999999999"));
  expectConfigError([&] { file.readReal("a length"); }, {"'1.5mm'"});
  expectConfigError([&] { file.readInteger("a count"); }, {"'3.0'"});
  expectConfigError([&] { file.readInteger("a count"); }, {"'99999999999999999999'"});
}

TEST(FileCursor, RefusesCountsThatCannotFit) {
  const TempFolder folder;
  const FileCursor file(folder.write("a.txt", "0123456789"));
  EXPECT_EQ(file.checkCount(5, 2, "items"), 5u);
  expectConfigError([&] { file.checkCount(6, 2, "items"); }, {"6", "10 bytes", "items"});
  expectConfigError([&] { file.checkCount(-1, 2, "items"); }, {"-1"});
  expectConfigError([&] { file.checkCount(INT64_MAX, 1 << 20, "items"); }, {"items"});
}

TEST(FileCursor, RefusesFoldersAndMissingFiles) {
  const TempFolder folder;
  expectConfigError([&] { FileCursor(folder.path("missing")); }, {"missing", "no such file"});
  expectConfigError([&] { FileCursor(folder.path("")); }, {"no such file"});
}

TEST(FileCursor, ReadsADecimalPointInEveryLocale) {
  const TempFolder folder;
  FileCursor file(folder.write("a.txt", "1.5"));
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
  }
  EXPECT_EQ(file.readReal("a number"), 1.5);
  std::setlocale(LC_NUMERIC, before.c_str());
}

}  // namespace
}  // namespace sinew
