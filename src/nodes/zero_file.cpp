#include "zero_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <limits>

namespace sinew {

std::map<std::string, double> ZeroFile::take() {
  std::map<std::string, double> zeros;
  if (path_.empty()) return zeros;
  try {
    for (const auto& entry : YAML::LoadFile(path_)) {
      const auto counts = entry.second.as<double>();
      if (std::isfinite(counts)) zeros[entry.first.as<std::string>()] = counts;
    }
  } catch (const std::exception&) {
    zeros.clear();
  }
  std::remove(path_.c_str());
  return zeros;
}

void ZeroFile::update(const std::vector<std::string>& names, const std::vector<double>& counts) {
  std::map<std::string, double> zeros;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::isfinite(counts[i])) zeros[names[i]] = counts[i];
  if (path_.empty() || zeros == written_) return;
  written_ = zeros;
  const std::string draft = path_ + ".new";
  {
    std::ofstream file(draft);
    file.precision(std::numeric_limits<double>::max_digits10);
    file << "# What devices count at displacement 0. Written by the driver, which deletes it when it starts.\n";
    for (const auto& [name, zero] : zeros) file << name << ": " << zero << "\n";
  }
  if (std::rename(draft.c_str(), path_.c_str()) != 0) std::remove(draft.c_str());
}

std::string makeZeroPath(const std::string& node) {
  const char* ros_home = std::getenv("ROS_HOME");
  const char* home = std::getenv("HOME");
  if (ros_home == nullptr && home == nullptr) return "";
  std::string name = node;
  std::replace(name.begin(), name.end(), '/', '_');
  return (ros_home != nullptr ? std::string(ros_home) : std::string(home) + "/.ros") + "/sinew_zeros" + name + ".yaml";
}

}  // namespace sinew
