#pragma once

#include <ros/node_handle.h>

#include <limits>
#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// The private parameters of a node, checked as they are read. Every complaint is a ConfigError that gives the full
/// name of the parameter (`/trunk/inverse_model/rate`), the value found and what would be right.
class Parameters {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  explicit Parameters(ros::NodeHandle node) : node_(std::move(node)) {}

  /// Limits are inclusive. A parameter without a default must be set.
  std::string text(const std::string& key) const;
  std::string textOr(const std::string& key, const std::string& otherwise) const;
  double number(const std::string& key, double min = -kInfinity, double max = kInfinity) const;
  double numberOr(const std::string& key, double otherwise, double min = -kInfinity, double max = kInfinity) const;
  int integerOr(const std::string& key, int otherwise, int min, int max) const;
  bool flagOr(const std::string& key, bool otherwise) const;
  /// A list of three numbers.
  Vec3 vec3Or(const std::string& key, const Vec3& otherwise) const;

  bool has(const std::string& key) const { return node_.hasParam(key); }
  std::string fullName(const std::string& key) const { return node_.resolveName(key); }
  [[noreturn]] void fail(const std::string& key, const std::string& found, const std::string& expected) const;

 private:
  XmlRpc::XmlRpcValue require(const std::string& key, const std::string& expected) const;

  ros::NodeHandle node_;
};

}  // namespace sinew
