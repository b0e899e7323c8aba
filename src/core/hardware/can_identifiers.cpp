#include "sinew/hardware/can_identifiers.h"

#include <cstdint>
#include <set>

#include "sinew/common/config_error.h"
#include "sinew/hardware/odrive_messages.h"

namespace sinew {
namespace {

// CiA 301, predefined connection set: emergency, four process data objects each way, service data both ways, heartbeat.
constexpr std::uint32_t kPerNode[] = {0x080, 0x180, 0x200, 0x280, 0x300, 0x380,
                                      0x400, 0x480, 0x500, 0x580, 0x600, 0x700};
constexpr std::uint32_t kOfAll[] = {0x000, 0x080, 0x100};  // network management, SYNC, time
constexpr std::uint32_t kHeartbeat = 0x700;

std::set<int> findTaken(const std::vector<CanNodeNumber>& canopen, int driver_node) {
  std::set<int> taken{static_cast<int>((kHeartbeat + static_cast<std::uint32_t>(driver_node)) >> 5)};
  for (const std::uint32_t id : kOfAll) taken.insert(static_cast<int>(id >> 5));
  for (const CanNodeNumber& n : canopen)
    for (const std::uint32_t id : kPerNode)
      taken.insert(static_cast<int>((id + static_cast<std::uint32_t>(n.number)) >> 5));
  return taken;
}

std::string listFree(const std::set<int>& taken) {
  std::string list;
  for (int n = 0; n <= kMaxOdriveNode; ++n)
    if (taken.count(n) == 0) list += (list.empty() ? "" : " ") + std::to_string(n);
  return list;
}

}  // namespace

void refuseSharedIdentifiers(const std::vector<CanNodeNumber>& odrives, const std::vector<CanNodeNumber>& canopen,
                             int driver_node) {
  if (canopen.empty()) return;
  const std::set<int> taken = findTaken(canopen, driver_node);
  for (const CanNodeNumber& o : odrives)
    if (taken.count(o.number) > 0)
      throw ConfigError(o.name + ".node", std::to_string(o.number) + ", whose identifiers CANopen drives use too",
                        "with these CANopen nodes one of " + listFree(taken));
}

}  // namespace sinew
