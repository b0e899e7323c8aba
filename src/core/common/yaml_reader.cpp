#include "sinew/common/yaml_reader.h"

#include <cmath>
#include <filesystem>
#include <sstream>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::string describe(const YAML::Node& node) {
  if (!node.IsDefined()) return "nothing";
  if (node.IsNull()) return "an empty value";
  if (node.IsScalar()) return "'" + node.Scalar() + "'";
  YAML::Emitter out;
  out << YAML::Flow << node;
  const std::string text = out.c_str();
  return text.size() <= 80 ? text : text.substr(0, 77) + "...";
}

std::string describeRange(double min, double max, const std::string& unit) {
  std::ostringstream out;
  out << "a number" << (unit.empty() ? "" : " of ") << unit;
  if (std::isfinite(min) && std::isfinite(max)) {
    out << " from " << min << " to " << max;
  } else if (std::isfinite(min)) {
    out << " >= " << min;
  } else if (std::isfinite(max)) {
    out << " <= " << max;
  }
  return out.str();
}

template <typename T>
bool convert(const YAML::Node& node, T& value) {
  return node.IsScalar() && YAML::convert<T>::decode(node, value);
}

bool convert(const YAML::Node& node, Vec3& value) {
  if (!node.IsSequence() || node.size() != 3) return false;
  for (int i = 0; i < 3; ++i) {
    if (!convert(node[i], value[i]) || !std::isfinite(value[i])) return false;
  }
  return true;
}

}  // namespace

YamlReader::YamlReader(const YAML::Node& node, std::string file, std::string prefix)
    : node_(node),
      file_(std::move(file)),
      prefix_(std::move(prefix)),
      asked_(std::make_shared<std::set<std::string>>()) {}

YamlReader YamlReader::fromFile(const std::string& path) {
  if (std::filesystem::is_directory(path)) throw ConfigError(path, "a folder", "a YAML file");
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root.IsMap()) throw ConfigError(path, describe(root), "a mapping of keys to values");
    return YamlReader(root, path, "");
  } catch (const YAML::BadFile&) {
    throw ConfigError(path, "no readable file", "a YAML file");
  } catch (const YAML::ParserException& e) {
    throw ConfigError(path, e.what(), "valid YAML");
  }
}

YamlReader YamlReader::fromText(const std::string& text, const std::string& name) {
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) throw ConfigError(name, describe(root), "a mapping of keys to values");
    return YamlReader(root, name, "");
  } catch (const YAML::ParserException& e) {
    throw ConfigError(name, e.what(), "valid YAML");
  }
}

YamlReader YamlReader::over(const YamlReader& common) const {
  YamlReader both = *this;
  both.common_ = std::make_shared<const YamlReader>(common);
  return both;
}

bool YamlReader::holds(const std::string& key) const {
  const YAML::Node& node = node_;
  return node[key].IsDefined();
}

bool YamlReader::has(const std::string& key) const {
  asked_->insert(key);
  if (common_ && !holds(key)) return common_->has(key);
  const YAML::Node& node = node_;
  return holds(key) && !node[key].IsNull();
}

bool YamlReader::isList(const std::string& key) const {
  return has(key) && require(key, "a list").IsSequence();
}

double YamlReader::number(const std::string& key, double min, double max, const std::string& unit) const {
  const std::string expected = describeRange(min, max, unit);
  const YAML::Node node = require(key, expected);
  double value = 0;
  if (!convert(node, value) || std::isnan(value) || value < min || value > max) fail(key, expected);
  return value;
}

double YamlReader::numberOr(const std::string& key, double otherwise, double min, double max) const {
  return has(key) ? number(key, min, max) : otherwise;
}

double YamlReader::positive(const std::string& key, const std::string& unit) const {
  const std::string expected = "a number" + (unit.empty() ? "" : " of " + unit) + " > 0";
  const YAML::Node node = require(key, expected);
  double value = 0;
  if (!convert(node, value) || !std::isfinite(value) || value <= 0) fail(key, expected);
  return value;
}

double YamlReader::positiveOr(const std::string& key, double otherwise) const {
  return has(key) ? positive(key) : otherwise;
}

int YamlReader::integer(const std::string& key, int min, int max) const {
  const std::string expected = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  const YAML::Node node = require(key, expected);
  int value = 0;
  if (!convert(node, value) || value < min || value > max) fail(key, expected);
  return value;
}

int YamlReader::integerOr(const std::string& key, int otherwise, int min, int max) const {
  return has(key) ? integer(key, min, max) : otherwise;
}

bool YamlReader::flagOr(const std::string& key, bool otherwise) const {
  if (!has(key)) return otherwise;
  bool value = false;
  if (!convert(require(key, "true or false"), value)) fail(key, "true or false");
  return value;
}

std::string YamlReader::text(const std::string& key) const {
  const YAML::Node node = require(key, "a text");
  if (!node.IsScalar() || node.Scalar().empty()) fail(key, "a text");
  return node.Scalar();
}

std::string YamlReader::textOr(const std::string& key, const std::string& otherwise) const {
  return has(key) ? text(key) : otherwise;
}

int YamlReader::choiceOr(const std::string& key, const std::vector<std::string>& choices, int otherwise) const {
  if (!has(key)) return otherwise;
  const std::string value = text(key);
  std::string expected = "one of";
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == value) return static_cast<int>(i);
    expected += (i == 0 ? " " : ", ") + choices[i];
  }
  fail(key, expected);
}

Vec3 YamlReader::vec3(const std::string& key) const {
  Vec3 value;
  if (!convert(require(key, "[x, y, z]"), value)) fail(key, "[x, y, z], three finite numbers");
  return value;
}

Vec3 YamlReader::vec3Or(const std::string& key, const Vec3& otherwise) const {
  return has(key) ? vec3(key) : otherwise;
}

std::vector<Vec3> YamlReader::vec3List(const std::string& key) const {
  const std::string expected = "a list of [x, y, z]";
  const YAML::Node node = require(key, expected);
  if (!node.IsSequence()) fail(key, expected);
  std::vector<Vec3> values(node.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!convert(node[i], values[i])) {
      throw ConfigError(fullName(key) + "[" + std::to_string(i) + "]", describe(node[i]), "[x, y, z]");
    }
  }
  return values;
}

std::vector<int> YamlReader::integerList(const std::string& key, int min, int max) const {
  const std::string expected = "a list of whole numbers from " + std::to_string(min) + " to " + std::to_string(max);
  const YAML::Node node = require(key, expected);
  if (!node.IsSequence()) fail(key, expected);
  std::vector<int> values(node.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!convert(node[i], values[i]) || values[i] < min || values[i] > max) {
      throw ConfigError(fullName(key) + "[" + std::to_string(i) + "]", describe(node[i]), expected);
    }
  }
  return values;
}

std::vector<std::string> YamlReader::textList(const std::string& key) const {
  const YAML::Node node = require(key, "a list of texts");
  if (!node.IsSequence()) fail(key, "a list of texts");
  std::vector<std::string> values;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) fail(key, "a list of texts");
    values.push_back(item.Scalar());
  }
  return values;
}

std::vector<std::vector<std::string>> YamlReader::textLists(const std::string& key) const {
  const YAML::Node node = require(key, "a list of lists of texts");
  if (!node.IsSequence()) fail(key, "a list of lists of texts");
  std::vector<std::vector<std::string>> lists;
  for (const YAML::Node& list : node) {
    if (!list.IsSequence()) fail(key, "a list of lists of texts");
    lists.emplace_back();
    for (const YAML::Node& item : list) {
      if (!item.IsScalar()) fail(key, "a list of lists of texts");
      lists.back().push_back(item.Scalar());
    }
  }
  return lists;
}

YamlReader YamlReader::map(const std::string& key) const {
  if (common_ && !holds(key) && common_->holds(key)) {
    asked_->insert(key);
    return common_->map(key);
  }
  const YAML::Node node = require(key, "a mapping");
  if (!node.IsMap()) fail(key, "a mapping");
  return YamlReader(node, file_, prefix_ + key + ".");
}

std::vector<YamlReader> YamlReader::maps(const std::string& key) const {
  if (!has(key)) return {};
  const YAML::Node node = require(key, "a list of mappings");
  if (!node.IsSequence()) fail(key, "a list of mappings");
  std::vector<YamlReader> readers;
  for (std::size_t i = 0; i < node.size(); ++i) {
    const std::string name = key + "[" + std::to_string(i) + "]";
    if (!node[i].IsMap()) throw ConfigError(fullName(name), describe(node[i]), "a mapping");
    readers.push_back(YamlReader(node[i], file_, prefix_ + name + "."));
  }
  return readers;
}

void YamlReader::refuseUnknownKeys() const {
  refuseKeysBeyond(*asked_);
  if (common_) common_->refuseKeysBeyond(*asked_);
}

void YamlReader::refuseKeysBeyond(const std::set<std::string>& asked) const {
  std::set<std::string> present;
  for (const auto& item : node_) {
    const std::string key = item.first.Scalar();
    if (!present.insert(key).second) throw ConfigError(fullName(key), "the key twice", "each key once");
    if (asked.count(key) != 0) continue;
    std::string expected = "only these keys:";
    for (const std::string& known : asked) expected += " " + known;
    throw ConfigError(fullName(key), "an unknown key", expected);
  }
}

void YamlReader::fail(const std::string& key, const std::string& expected) const {
  if (common_ && !holds(key)) common_->fail(key, expected);
  const YAML::Node& node = node_;
  throw ConfigError(fullName(key), describe(node[key]), expected);
}

std::string YamlReader::path(const std::string& key) const {
  std::string value = text(key);
  const std::size_t slash = file_.rfind('/');
  if (value.front() == '/' || slash == std::string::npos) return value;
  return file_.substr(0, slash + 1) + value;
}

YAML::Node YamlReader::require(const std::string& key, const std::string& expected) const {
  asked_->insert(key);
  if (common_ && !holds(key)) {
    if (common_->holds(key)) return common_->require(key, expected);
    throw ConfigError(fullName(key) + " (or " + common_->prefix_ + key + ")", "nothing", expected);
  }
  const YAML::Node& node = node_;
  if (!holds(key)) throw ConfigError(fullName(key), "nothing", expected);
  return node[key];
}

std::string YamlReader::fullName(const std::string& key) const {
  return file_ + ": " + prefix_ + key;
}

}  // namespace sinew
