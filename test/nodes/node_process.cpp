#include "node_process.h"

#include <XmlRpcClient.h>
#include <XmlRpcValue.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <unistd.h>

#include <boost/filesystem.hpp>
#include <fstream>
#include <sstream>

namespace sinew {
namespace {

/// The fields of a `stat` file behind the name, which may hold blanks: the first is the state, field 3 of proc(5).
ThreadUse parse(const std::string& stat) {
  std::istringstream fields(stat.substr(stat.rfind(')') + 2));
  ThreadUse use;
  std::string state;
  long skipped, user, system;
  fields >> state;
  for (int k = 4; k <= 9; ++k) fields >> skipped;
  fields >> use.minor_faults >> skipped >> use.major_faults >> skipped >> user >> system;
  use.processor_time = static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  return use;
}

}  // namespace

pid_t findProcess(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return -1;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(std::string(uri), host, port)) return -1;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, answer) || client.isFault()) return -1;
  return static_cast<int>(answer[2]);
}

ThreadUse readThreadUse(pid_t process, const std::string& thread) {
  namespace files = boost::filesystem;
  const files::path tasks = "/proc/" + std::to_string(process) + "/task";
  boost::system::error_code gone;
  for (files::directory_iterator task(tasks, gone), end; !gone && task != end; task.increment(gone)) {
    std::string name, stat;
    std::ifstream names((task->path() / "comm").string()), stats((task->path() / "stat").string());
    if (std::getline(names, name) && name == thread && std::getline(stats, stat)) return parse(stat);
  }
  return ThreadUse();
}

}  // namespace sinew
