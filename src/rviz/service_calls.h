#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace sinew {

struct ServiceAnswer {
  std::string service;
  bool success = false;
  std::string message;
};

/// Calls services of type std_srvs/Trigger, each in a thread of its own: homing may take a minute, and who halts does
/// not wait for it.
class ServiceCalls {
 public:
  /// Calls `service`, a resolved name, unless a call of it is under way.
  void start(const std::string& service);

  bool underWay(const std::string& service) const;

  /// The answers since the last time, oldest first.
  std::vector<ServiceAnswer> takeAnswers();

 private:
  struct Shared {
    std::mutex mutex;
    std::set<std::string> under_way;
    std::vector<ServiceAnswer> answers;
  };

  static void call(const std::string& service, Shared& shared);

  std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();  // outlives a panel that is closed during a call
};

}  // namespace sinew
