#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace sinew {

/// What devices count at displacement 0, kept for the next life of the driver: whether that still holds is for the
/// devices to tell (DeviceBus::restoreZero). Taking it deletes the file, so that what a crash leaves behind is never
/// older than the last set-up.
class ZeroFile {
 public:
  /// `path`: empty for none. Nothing here throws: without the file the robot is homed again.
  explicit ZeroFile(std::string path) : path_(std::move(path)) {}

  /// Counts by the actuator's name; empty when there is no file, or nothing sensible in it.
  std::map<std::string, double> take();
  /// Writes the file anew when something has changed. Values that are not finite are left out.
  void update(const std::vector<std::string>& names, const std::vector<double>& counts);

 private:
  std::string path_;
  std::map<std::string, double> written_;
};

/// Where the node of that name keeps its zeros: ~/.ros/sinew_zeros_NAME.yaml, or below ROS_HOME where that is set.
std::string makeZeroPath(const std::string& node);

}  // namespace sinew
