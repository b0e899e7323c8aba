#pragma once

#include <stdexcept>
#include <string>

namespace sinew {

/// Thrown at set-up when a parameter, key or file is missing or wrong. The message names it in full, gives the value
/// found and says what would be right.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const std::string& name, const std::string& found, const std::string& expected);
  explicit ConfigError(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace sinew
