#include "sinew/hardware/pseudo_terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "file_descriptor.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr int kBaud = 115200;  // a pseudo-terminal ignores it

std::string readLink(const std::string& link) {
  char target[PATH_MAX];
  const ssize_t size = readlink(link.c_str(), target, sizeof target);
  return size > 0 ? std::string(target, static_cast<std::size_t>(size)) : std::string();
}

void makeLink(const std::string& target, const std::string& link) {
  struct stat info {};
  if (lstat(link.c_str(), &info) == 0 && S_ISLNK(info.st_mode)) unlink(link.c_str());
  if (symlink(target.c_str(), link.c_str()) != 0)
    throw ConfigError("link to the simulated port", link, std::string("a path to make (") + strerror(errno) + ")");
}

}  // namespace

PseudoTerminal::PseudoTerminal(const std::string& link) : link_(link) {
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  char name[128] = {};
  if (master_ >= 0 && grantpt(master_) == 0 && unlockpt(master_) == 0 && ptsname_r(master_, name, sizeof name) == 0)
    slave_ = open(name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (slave_ < 0 || !makeRaw(slave_, kBaud)) {
    const std::string reason = strerror(errno);
    if (slave_ >= 0) close(slave_);
    if (master_ >= 0) close(master_);
    throw ConfigError("pseudo-terminal", reason, "a free one");
  }
  path_ = name;
  try {
    if (!link_.empty()) makeLink(path_, link_);
  } catch (...) {
    close(slave_);
    close(master_);
    throw;
  }
}

PseudoTerminal::~PseudoTerminal() {
  if (!link_.empty() && readLink(link_) == path_) unlink(link_.c_str());
  close(slave_);
  close(master_);
}

StreamResult PseudoTerminal::read(std::uint8_t* data, std::size_t capacity, Duration timeout) {
  return readDescriptor(master_, data, capacity, timeout);
}

StreamResult PseudoTerminal::write(const std::uint8_t* data, std::size_t size, Duration timeout) {
  return writeDescriptor(master_, data, size, timeout);
}

}  // namespace sinew
