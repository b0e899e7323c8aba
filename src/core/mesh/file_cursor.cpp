#include "sinew/mesh/file_cursor.h"

#include <locale.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr std::size_t kQuoteLength = 40;

bool isSpace(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

/// `text` in quotes, short enough for a message and without unprintable characters.
std::string quote(std::string_view text) {
  std::string quoted(text.substr(0, kQuoteLength));
  std::replace_if(
      quoted.begin(), quoted.end(), [](char c) { return std::isprint(static_cast<unsigned char>(c)) == 0; }, '?');
  return "'" + quoted + (text.size() > kQuoteLength ? "...'" : "'");
}

/// Reads with a decimal point whatever the locale of the process is.
double parseReal(const char* begin, char** end) {
  static const locale_t kC = newlocale(LC_ALL_MASK, "C", static_cast<locale_t>(nullptr));
  return strtod_l(begin, end, kC);
}

std::string readFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw ConfigError(path, "no such file", "a readable file");
  std::ifstream stream(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) throw ConfigError(path, "a file that cannot be read", "a readable file");
  return bytes;
}

}  // namespace

FileCursor::FileCursor(const std::string& path) : path_(path), bytes_(readFile(path)) {}

bool FileCursor::isAtEnd() {
  skipSpace();
  return at_ == bytes_.size();
}

void FileCursor::skipSpace() {
  while (at_ < bytes_.size() && isSpace(bytes_[at_])) ++at_;
}

std::string_view FileCursor::peekWord() {
  skipSpace();
  std::size_t end = at_;
  while (end < bytes_.size() && !isSpace(bytes_[end])) ++end;
  return std::string_view(bytes_).substr(at_, end - at_);
}

std::string_view FileCursor::readWord(const char* expected) {
  const std::string_view word = peekWord();
  item_ = at_;
  if (word.empty()) fail("the end of the file", expected);
  at_ += word.size();
  return word;
}

void FileCursor::expectWord(std::string_view word) {
  const std::string expected(word);
  const std::string_view found = readWord(expected.c_str());
  if (found != word) fail(quote(found), expected);
}

std::int64_t FileCursor::readInteger(const char* expected) {
  const std::string_view word = readWord(expected);
  std::int64_t value = 0;
  const std::from_chars_result result = std::from_chars(word.data(), word.data() + word.size(), value);
  if (result.ec != std::errc() || result.ptr != word.data() + word.size()) {
    fail(quote(word), std::string("an integer: ") + expected);
  }
  return value;
}

double FileCursor::readReal(const char* expected) {
  const std::string_view word = readWord(expected);
  char* end = nullptr;
  const double value = parseReal(word.data(), &end);
  if (end != word.data() + word.size()) fail(quote(word), std::string("a number: ") + expected);
  return value;
}

bool FileCursor::hasWordOnLine() const {
  std::size_t next = at_;
  while (next < bytes_.size() && bytes_[next] != '\n' && isSpace(bytes_[next])) ++next;
  return next < bytes_.size() && bytes_[next] != '\n';
}

std::string_view FileCursor::readLine() {
  item_ = at_;
  const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
  std::string_view line = std::string_view(bytes_).substr(at_, end - at_);
  at_ = std::min(end + 1, bytes_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

void FileCursor::skipPast(std::string_view text) {
  item_ = at_;
  const std::size_t found = bytes_.find(text, at_);
  if (found == std::string::npos) fail("the end of the file", std::string(text));
  at_ = found + text.size();
}

std::size_t FileCursor::checkCount(std::int64_t count, std::size_t bytes_each, const char* expected) const {
  const std::size_t left = bytes_.size() - at_ + 1;  // the last word of a file needs no space behind it
  if (count < 0 || static_cast<std::size_t>(count) > left / bytes_each) {
    fail(std::to_string(count) + ", more than the " + std::to_string(bytes_.size() - at_) + " bytes that follow",
         expected);
  }
  return static_cast<std::size_t>(count);
}

void FileCursor::skipBytes(std::size_t count, const char* expected) {
  item_ = at_;
  is_binary_ = true;
  if (count > bytes_.size() - at_) fail("the end of the file", expected);
  at_ += count;
}

void FileCursor::copyBytes(char* destination, std::size_t count, bool swap, const char* expected) {
  skipBytes(count, expected);
  std::memcpy(destination, bytes_.data() + item_, count);
  if (swap) std::reverse(destination, destination + count);
}

std::string FileCursor::describePlace() const {
  if (is_binary_) return "byte " + std::to_string(item_);
  return "line " +
         std::to_string(1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(item_), '\n'));
}

void FileCursor::fail(const std::string& found, const std::string& expected) const {
  throw ConfigError(path_ + ", " + describePlace(), found, expected);
}

void FileCursor::failFile(const std::string& found, const std::string& expected) const {
  throw ConfigError(path_, found, expected);
}

bool isLittleEndian() {
  const std::uint16_t one = 1;
  char first = 0;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

}  // namespace sinew
