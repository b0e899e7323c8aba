#include "service_calls.h"

#include <ros/service.h>
#include <std_srvs/Trigger.h>

#include <thread>
#include <utility>

namespace sinew {

void ServiceCalls::start(const std::string& service) {
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    if (!shared_->under_way.insert(service).second) return;
  }
  std::thread([service, shared = shared_] { call(service, *shared); }).detach();
}

bool ServiceCalls::underWay(const std::string& service) const {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return shared_->under_way.count(service) != 0;
}

std::vector<ServiceAnswer> ServiceCalls::takeAnswers() {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  return std::exchange(shared_->answers, {});
}

void ServiceCalls::call(const std::string& service, Shared& shared) {
  std_srvs::Trigger trigger;
  const bool reached = ros::service::call(service, trigger);
  const std::lock_guard<std::mutex> lock(shared.mutex);
  shared.under_way.erase(service);
  if (reached)
    shared.answers.push_back({service, trigger.response.success != 0, trigger.response.message});
  else
    shared.answers.push_back({service, false, "no such service: is its node running?"});
}

}  // namespace sinew
