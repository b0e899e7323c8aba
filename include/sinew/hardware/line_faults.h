#pragma once

#include <cstdint>

namespace sinew {

/// What a bad line does to status packets, each packet by at most one of them. Probabilities per packet.
struct LineFaults {
  double corrupt = 0;        ///< one to three bits of the packet are flipped
  double drop = 0;           ///< the packet is never sent
  double delay = 0;          ///< the packet is sent `delay_time` late
  double delay_time = 0.02;  ///< s
  std::uint32_t seed = 1;    ///< of the random numbers that pick the packets
};

/// Status packets treated so far, counted at the moment of injection.
struct LineFaultCounts {
  std::uint64_t sent = 0;  ///< packets that left unharmed and in time
  std::uint64_t corrupted = 0;
  std::uint64_t dropped = 0;
  std::uint64_t delayed = 0;
};

}  // namespace sinew
