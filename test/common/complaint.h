#pragma once

#include <string>

#include "sinew/common/config_error.h"

namespace sinew {

/// What a call complains of; empty when it does not.
template <typename Call>
std::string complaintOf(Call&& call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace sinew
