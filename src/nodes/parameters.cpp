#include "parameters.h"

#include <cmath>
#include <sstream>

#include "sinew/common/config_error.h"

namespace sinew {

namespace {

std::string describe(const XmlRpc::XmlRpcValue& value) {
  std::ostringstream stream;
  value.write(stream);
  return stream.str();
}

bool isNumber(const XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeDouble || value.getType() == XmlRpc::XmlRpcValue::TypeInt;
}

double toNumber(XmlRpc::XmlRpcValue value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt ? static_cast<int>(value) : static_cast<double>(value);
}

std::string describeRange(const char* kind, double min, double max) {
  std::ostringstream stream;
  stream << kind;
  if (std::isfinite(min) && std::isfinite(max)) {
    stream << " from " << min << " to " << max;
  } else if (std::isfinite(min)) {
    stream << " of at least " << min;
  } else if (std::isfinite(max)) {
    stream << " of at most " << max;
  }
  return stream.str();
}

}  // namespace

void Parameters::fail(const std::string& key, const std::string& found, const std::string& expected) const {
  throw ConfigError("parameter " + fullName(key), found, expected);
}

XmlRpc::XmlRpcValue Parameters::require(const std::string& key, const std::string& expected) const {
  XmlRpc::XmlRpcValue value;
  if (!node_.getParam(key, value)) fail(key, "nothing", expected);
  return value;
}

std::string Parameters::text(const std::string& key) const {
  const char* const expected = "a text that is not empty";
  XmlRpc::XmlRpcValue value = require(key, expected);
  if (value.getType() != XmlRpc::XmlRpcValue::TypeString) fail(key, describe(value), expected);
  const std::string result = value;
  if (result.empty()) fail(key, "an empty text", expected);
  return result;
}

std::string Parameters::textOr(const std::string& key, const std::string& otherwise) const {
  return has(key) ? text(key) : otherwise;
}

double Parameters::number(const std::string& key, double min, double max) const {
  const std::string expected = describeRange("a number", min, max);
  const XmlRpc::XmlRpcValue value = require(key, expected);
  if (!isNumber(value)) fail(key, describe(value), expected);
  const double result = toNumber(value);
  if (!(result >= min && result <= max)) fail(key, describe(value), expected);
  return result;
}

double Parameters::numberOr(const std::string& key, double otherwise, double min, double max) const {
  return has(key) ? number(key, min, max) : otherwise;
}

int Parameters::integerOr(const std::string& key, int otherwise, int min, int max) const {
  if (!has(key)) return otherwise;
  const std::string expected = describeRange("a whole number", min, max);
  const double result = number(key, min, max);
  if (result != std::floor(result)) fail(key, describe(require(key, expected)), expected);
  return static_cast<int>(result);
}

bool Parameters::flagOr(const std::string& key, bool otherwise) const {
  if (!has(key)) return otherwise;
  XmlRpc::XmlRpcValue value = require(key, "true or false");
  if (value.getType() != XmlRpc::XmlRpcValue::TypeBoolean) fail(key, describe(value), "true or false");
  return value;
}

Vec3 Parameters::vec3Or(const std::string& key, const Vec3& otherwise) const {
  if (!has(key)) return otherwise;
  const char* const expected = "a list of three numbers";
  XmlRpc::XmlRpcValue value = require(key, expected);
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray || value.size() != 3) fail(key, describe(value), expected);
  Vec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    if (!isNumber(value[axis])) fail(key, describe(value), expected);
    result[axis] = toNumber(value[axis]);
  }
  return result;
}

}  // namespace sinew
