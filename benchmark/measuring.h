#pragma once

#include <vector>

namespace sinew {

/// The calling thread stays on the core that it runs on, with the priority of a controller's cycle where that is
/// allowed.
void pinToOneCore();

/// Sleeps a tenth as long as the work [s] took: the kernel stops real-time threads that never do.
void rest(double worked);

/// The middle one; the lower of two. 0 without any.
int calcMedian(std::vector<int> values);

}  // namespace sinew
