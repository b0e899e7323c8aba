#pragma once

#include <string>
#include <vector>

namespace sinew {

/// A device on a CAN bus, as far as its identifiers depend on it.
struct CanNodeNumber {
  std::string name;  ///< for messages
  int number = 0;
};

/// Throws ConfigError when on one bus an ODrive would take frames of CANopen for its own: ODrive node n owns the 32
/// identifiers from 32 n on, and CANopen its predefined connection set (CiA 301) of every node and of the driver's own
/// node `driver_node`, SYNC and network management included. The message says which numbers would be free.
void refuseSharedIdentifiers(const std::vector<CanNodeNumber>& odrives, const std::vector<CanNodeNumber>& canopen,
                             int driver_node);

}  // namespace sinew
