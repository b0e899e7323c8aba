#pragma once

#include <yaml-cpp/yaml.h>

#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// One mapping of a YAML file, read key by key. Every complaint is a ConfigError that gives the file, the full name of
/// the key (`trunk.yaml: cables[2].tension.max`), the value found and what would be right.
class YamlReader {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static YamlReader fromFile(const std::string& path);
  static YamlReader fromText(const std::string& text, const std::string& name);

  /// This mapping, with `common` for every key that it leaves out.
  YamlReader over(const YamlReader& common) const;

  bool has(const std::string& key) const;
  bool isList(const std::string& key) const;

  /// Limits are inclusive; `.inf` is taken where the upper limit is infinite. `unit` is for the complaint.
  double number(const std::string& key, double min = -kInfinity, double max = kInfinity,
                const std::string& unit = "") const;
  double numberOr(const std::string& key, double otherwise, double min = -kInfinity, double max = kInfinity) const;
  double positive(const std::string& key, const std::string& unit = "") const;
  double positiveOr(const std::string& key, double otherwise) const;
  int integer(const std::string& key, int min, int max) const;
  int integerOr(const std::string& key, int otherwise, int min, int max) const;
  bool flagOr(const std::string& key, bool otherwise) const;
  std::string text(const std::string& key) const;
  std::string textOr(const std::string& key, const std::string& otherwise) const;
  /// One of `choices`; returns its index.
  int choiceOr(const std::string& key, const std::vector<std::string>& choices, int otherwise) const;
  Vec3 vec3(const std::string& key) const;
  Vec3 vec3Or(const std::string& key, const Vec3& otherwise) const;
  std::vector<Vec3> vec3List(const std::string& key) const;
  std::vector<int> integerList(const std::string& key, int min, int max) const;
  std::vector<std::string> textList(const std::string& key) const;
  std::vector<std::vector<std::string>> textLists(const std::string& key) const;

  /// A nested mapping.
  YamlReader map(const std::string& key) const;
  /// A list of mappings; empty when the key is missing.
  std::vector<YamlReader> maps(const std::string& key) const;

  /// Throws when this mapping holds a key that nobody has asked for: a misspelt key must not pass as a default.
  void refuseUnknownKeys() const;

  [[noreturn]] void fail(const std::string& key, const std::string& expected) const;

  /// A path in the file, relative to the file's own folder.
  std::string path(const std::string& key) const;

 private:
  YamlReader(const YAML::Node& node, std::string file, std::string prefix);
  void refuseKeysBeyond(const std::set<std::string>& asked) const;
  bool holds(const std::string& key) const;
  YAML::Node require(const std::string& key, const std::string& expected) const;
  std::string fullName(const std::string& key) const;

  YAML::Node node_;
  std::string file_;
  std::string prefix_;
  std::shared_ptr<const YamlReader> common_;
  std::shared_ptr<std::set<std::string>> asked_;
};

}  // namespace sinew
