#include "measuring.h"

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "real_time.h"

namespace sinew {

void pinToOneCore() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(sched_getcpu(), &cores);
  sched_setaffinity(0, sizeof cores, &cores);
  requestRealTime(kCyclePriority);
}

void rest(double worked) {
  std::this_thread::sleep_for(std::chrono::duration<double>(0.1 * worked));
}

int calcMedian(std::vector<int> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sinew
