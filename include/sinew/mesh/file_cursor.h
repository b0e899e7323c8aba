#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sinew {

/// A place in a file of which parts are text and parts may be binary numbers. The whole file is held in memory; words
/// and lines are views into it. Everything that cannot be read throws a ConfigError that names file, line (byte offset
/// once binary numbers have been read), what was found and what was expected.
class FileCursor {
 public:
  explicit FileCursor(const std::string& path);
  FileCursor(const FileCursor&) = delete;
  FileCursor& operator=(const FileCursor&) = delete;

  const std::string& path() const { return path_; }

  /// Passes over white space; whether nothing follows.
  bool isAtEnd();
  /// The next word between white space, without moving.
  std::string_view peekWord();
  /// The next word between white space; `expected` says what it means in errors.
  std::string_view readWord(const char* expected);
  void expectWord(std::string_view word);
  std::int64_t readInteger(const char* expected);
  double readReal(const char* expected);

  /// Whether another word follows on this line.
  bool hasWordOnLine() const;
  /// The rest of this line, without its end (LF or CRLF), which is passed over.
  std::string_view readLine();
  /// Moves behind the next occurrence of `text`.
  void skipPast(std::string_view text);

  /// Throws unless `count` is >= 0 and `count` items of at least `bytes_each` can still follow: call it before
  /// allocating. Returns `count`.
  std::size_t checkCount(std::int64_t count, std::size_t bytes_each, const char* expected) const;

  /// One binary number; `swap` if its bytes are not in the order of this machine.
  template <typename T>
  T readBinary(bool swap, const char* expected) {
    T value;
    copyBytes(reinterpret_cast<char*>(&value), sizeof(T), swap, expected);
    return value;
  }
  void skipBytes(std::size_t count, const char* expected);

  /// Throws the ConfigError of the item read last.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  /// Throws a ConfigError of the file as a whole.
  [[noreturn]] void failFile(const std::string& found, const std::string& expected) const;

 private:
  void skipSpace();
  void copyBytes(char* destination, std::size_t count, bool swap, const char* expected);
  std::string describePlace() const;

  std::string path_;
  std::string bytes_;
  std::size_t at_ = 0;      // next byte
  std::size_t item_ = 0;    // begin of the item read last
  bool is_binary_ = false;  // lines have lost their meaning
};

/// Whether this machine stores the least significant byte first.
bool isLittleEndian();

}  // namespace sinew
