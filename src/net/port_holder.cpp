#include "port_holder.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "raven2_trainer/core/shown.h"

namespace raven2_trainer::net {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCommandShown = 80;  // [characters]

/** A line of /proc/net/tcp, tcp6, udp or udp6. */
struct Holder {
  std::uint64_t inode{};  // 0: no program has it any more
  std::uint32_t user{};
};

/** "0100007F:8CA0": the address as it lies in memory, of IPv6 all four words of it, and the port. IPv6 sockets count,
 *  too: one bound to "any" has the port of IPv4 as well. */
bool isOurs(const std::string& local, const Endpoint& endpoint) {
  const std::size_t colon = local.find(':');
  if (colon == std::string::npos || colon < 8) return false;
  if (std::stoul(local.substr(colon + 1), nullptr, 16) != endpoint.port) return false;
  const auto last = static_cast<std::uint32_t>(std::stoul(local.substr(colon - 8, 8), nullptr, 16));
  const std::uint32_t ours = htonl(endpoint.address);
  return last == ours || last == 0 || ours == 0;
}

/** A socket that a program has comes before a connection that has ended. */
std::optional<Holder> lookUp(const std::string& table, const Endpoint& endpoint) {
  std::ifstream file("/proc/net/" + table);
  std::optional<Holder> found;
  std::string line;
  std::getline(file, line);  // titles
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string number, local, remote, state, queues, timer, retransmitted, timeout;
    Holder holder;
    words >> number >> local >> remote >> state >> queues >> timer >> retransmitted >> holder.user >> timeout >>
        holder.inode;
    if (!words || !isOurs(local, endpoint)) continue;
    if (holder.inode != 0) return holder;
    found = holder;
  }
  return found;
}

bool has(const fs::path& process, std::uint64_t inode) {
  const std::string socket = "socket:[" + std::to_string(inode) + "]";
  std::error_code error;
  for (fs::directory_iterator file(process / "fd", error), end; !error && file != end; file.increment(error)) {
    std::error_code gone;
    if (fs::read_symlink(file->path(), gone) == socket) return true;
  }
  return false;
}

/** As it was typed, without the folder of the program. */
std::string commandOf(const fs::path& process) {
  std::ifstream file(process / "cmdline");
  std::string command, word;
  while (std::getline(file, word, '\0'))
    command += command.empty() ? fs::path(word).filename().string() : " " + word;
  return shown(command, kCommandShown);
}

/** @return empty if it is another user's. */
fs::path processWith(std::uint64_t inode) {
  std::error_code error;
  for (fs::directory_iterator each("/proc", error), end; !error && each != end; each.increment(error)) {
    const std::string name = each->path().filename();
    if (std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; }) &&
        has(each->path(), inode))
      return each->path();
  }
  return {};
}

}  // namespace

std::string portHolder(const Endpoint& endpoint, int type) {
  const std::string protocol = type == SOCK_STREAM ? "tcp" : "udp";
  std::optional<Holder> holder = lookUp(protocol, endpoint);
  if (!holder || holder->inode == 0) {
    const std::optional<Holder> other = lookUp(protocol + "6", endpoint);
    if (other) holder = other;
  }
  if (!holder) return "No program has it now: start again";
  if (holder->inode == 0) return "A connection that has just ended has it for up to a minute: wait";
  const fs::path process = processWith(holder->inode);
  if (process.empty()) return "A program of user " + std::to_string(holder->user) + " has it: ask for its end";
  return "Process " + process.filename().string() + " (" + commandOf(process) + ") has it: end it";
}

}  // namespace raven2_trainer::net
