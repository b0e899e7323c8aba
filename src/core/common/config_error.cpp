#include "sinew/common/config_error.h"

namespace sinew {

ConfigError::ConfigError(const std::string& name, const std::string& found, const std::string& expected)
    : std::runtime_error(name + ": found " + found + ", expected " + expected) {}

}  // namespace sinew
