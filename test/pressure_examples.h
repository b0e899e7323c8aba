#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace sinew {

/// A worked example of docs/pressure_board_protocol.md: a message's fields, its bytes on a serial line, its CAN frames.
struct PressureExample {
  using Bytes = std::vector<std::uint8_t>;
  using Fields = std::map<std::string, std::int64_t>;
  struct Can {
    std::uint32_t id;
    Bytes data;
  };

  std::string name;
  std::vector<Fields> fields;  ///< one element a line
  Bytes packet, frame;         ///< empty where only CAN knows the message
  std::vector<Can> can;

  /// A field of the message as a whole, or of channel `channel`.
  std::int64_t at(const std::string& field, int channel = -1) const {
    for (const Fields& line : fields) {
      const auto of = line.find("channel");
      const bool here = channel < 0 ? of == line.end() : of != line.end() && of->second == channel;
      if (here && line.count(field) != 0) return line.at(field);
    }
    throw std::out_of_range(name + ": " + field);
  }

  static Bytes parseHex(std::istream& in) {
    Bytes bytes;
    std::string word;
    while (in >> word) bytes.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
    return bytes;
  }

  void parseLine(const std::string& text) {
    std::istringstream in(text);
    std::string word;
    in >> word;
    if (word == "packet") {
      packet = parseHex(in);
    } else if (word == "frame") {
      frame = parseHex(in);
    } else if (word == "can") {
      in >> word;
      can.push_back({static_cast<std::uint32_t>(std::stoul(word, nullptr, 16)), parseHex(in)});
    } else if (name.empty()) {
      name = word;
    } else {
      Fields line;
      std::int64_t value = 0;
      char comma = 0;
      for (in >> value, line[word] = value; in >> comma >> word >> value;) line[word] = value;
      fields.push_back(line);
    }
  }

  /// Every example of the document, by name.
  static std::map<std::string, PressureExample> load() {
    std::ifstream file(SINEW_SOURCE_DIR "/docs/pressure_board_protocol.md");
    std::map<std::string, PressureExample> examples;
    std::string line;
    while (std::getline(file, line)) {
      if (line != "```example") continue;
      PressureExample example;
      while (std::getline(file, line) && line != "```") example.parseLine(line);
      examples[example.name] = example;
    }
    return examples;
  }
};

}  // namespace sinew
