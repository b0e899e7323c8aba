#pragma once

#include <cstdint>

namespace sinew {

/// What a bad line does to the packets or frames of the devices, each by at most one of them. Probabilities per packet.
struct LineFaults {
  double corrupt = 0;        ///< one to three bits of the packet are flipped; on CAN, whose controllers refuse such
                             ///< frames, the frame is lost and counted as corrupted
  double drop = 0;           ///< the packet is never sent
  double delay = 0;          ///< the packet is sent `delay_time` late
  double duplicate = 0;      ///< the packet is sent twice
  double delay_time = 0.02;  ///< s
  std::uint32_t seed = 1;    ///< of the random numbers that pick the packets
};

/// Packets treated so far, counted at the moment of injection.
struct LineFaultCounts {
  std::uint64_t sent = 0;  ///< packets that left unharmed and in time
  std::uint64_t corrupted = 0;
  std::uint64_t dropped = 0;
  std::uint64_t delayed = 0;
  std::uint64_t duplicated = 0;
};

}  // namespace sinew
