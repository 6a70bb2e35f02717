#include "preload/interpose/injector.h"

#include <netinet/in.h>
#include <pthread.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <string>

#include "raven2_trainer/preload/board_faults.h"
#include "raven2_trainer/preload/ground_truth.h"
#include "raven2_trainer/preload/network_faults.h"
#include "raven2_trainer/preload/settings.h"

namespace raven2_trainer::preload {
namespace {

constexpr std::size_t kDescriptors = 4096;  // a control program has some dozens

/** Everything that acts. Never freed: the program's threads may outlive its main(). */
struct Injector {
  explicit Injector(const Order& what, std::string truth)
      : order(what), truth_path(std::move(truth)), boards(order.plan, &history), network(order.plan, &history) {}

  Order order;
  std::string truth_path;
  pid_t process{getpid()};  // a forked child shares this memory, and writes no truth file
  CycleHistory history;
  BoardFaults boards;
  NetworkFaults network;
};

std::array<std::atomic<std::uint8_t>, kDescriptors> roles{};
/** Where a packet of the other arm's goes that a fault sends here: one that the program writes to. Its own packets go
 * to the descriptor that they are written to, whatever else is open. */
std::array<std::atomic<int>, kArmCount> board_descriptors{-1, -1};
std::atomic<Injector*> injector{nullptr};
std::atomic<bool> is_decided{false};

/** The environment as the program found it. Never freed, as above. */
const Settings& settings() {
  static const Settings& read =
      *new Settings(settingsFrom([](const char* name) -> const char* { return std::getenv(name); }));
  return read;
}

void say(const std::string& line) {
  std::fprintf(stderr, "raven2_usb_faults: %s\n", line.c_str());
}

void switchOn() {
  const Settings& s = settings();
  portOf(s);
  const Order order = orderOf(s);
  auto made = std::make_unique<Injector>(order, s.truth);
  say("ON: scenario " + order.scenario.name + ", " + std::to_string(order.plan.count) +
      " rows, acts on what this program reads from and writes to " + s.gold + " and " + s.green +
      ", and receives on UDP port " + s.port);
  injector.store(made.release(), std::memory_order_release);
}

void decideOnce() noexcept {
  try {
    switchOn();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "raven2_usb_faults: OFF, everything passes through untouched: %s\n", e.what());
  } catch (...) {
    std::fprintf(stderr, "raven2_usb_faults: OFF, everything passes through untouched: unknown error\n");
  }
  is_decided.store(true, std::memory_order_release);
}

/** Once, with the first board or packet: the one call that allocates and waits. */
void decide() noexcept {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  if (is_decided.load(std::memory_order_acquire)) return;
  const int error = errno;
  pthread_once(&once, decideOnce);
  errno = error;
}

void setRole(int descriptor, Role role) noexcept {
  if (descriptor < 0 || static_cast<std::size_t>(descriptor) >= kDescriptors) return;
  roles[static_cast<std::size_t>(descriptor)].store(static_cast<std::uint8_t>(role), std::memory_order_release);
}

/** Another descriptor of the same board, or -1. */
int anyOf(Role role) noexcept {
  for (std::size_t i = 0; i < kDescriptors; ++i) {
    if (roles[i].load(std::memory_order_acquire) == static_cast<std::uint8_t>(role)) return static_cast<int>(i);
  }
  return -1;
}

bool isNoBoardOpen() noexcept {
  return std::all_of(board_descriptors.begin(), board_descriptors.end(),
                     [](const std::atomic<int>& board) { return board.load(std::memory_order_acquire) < 0; });
}

/** raven2 numbers its boards as it opens them (USB_init.cpp: USBInit), by descending names: which arm's is the first
 * depends on the robot's serials. */
void numberFrom(Arm first) noexcept {
  Injector* made = injector.load(std::memory_order_acquire);
  if (made != nullptr) made->boards.numberFrom(first);
}

void replace(Arm arm, int from, int to) noexcept {
  at(board_descriptors, arm).compare_exchange_strong(from, to, std::memory_order_acq_rel);
}

std::int64_t nowNs(clockid_t clock = CLOCK_REALTIME) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1000000000 + now.tv_nsec;
}

/** [UDP or TCP port] that a socket is bound to; 0 for other descriptors. */
std::uint16_t boundPort(int descriptor) noexcept {
  const int error = errno;
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  std::uint16_t port = 0;
  if (getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    if (address.ss_family == AF_INET) port = ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
    if (address.ss_family == AF_INET6) port = ntohs(reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port);
  }
  errno = error;
  return port;
}

bool isItpPort(std::uint16_t port) noexcept {
  const unsigned long wanted = std::strtoul(settings().port.c_str(), nullptr, 10);
  return port != 0 && port == wanted;
}

/** One that is neither arm's passes through, which should not go unnoticed. */
void warnOfBoard(const char* path) noexcept {
  const char* name = std::strrchr(path, '/');
  if (std::strncmp(name == nullptr ? path : name + 1, "brl_usb", 7) != 0) return;
  std::fprintf(
      stderr,
      "raven2_usb_faults: %s is neither RAVEN2_USB_FAULTS_GOLD (%s) nor RAVEN2_USB_FAULTS_GREEN (%s): it passes "
      "through\n",
      path, settings().gold.c_str(), settings().green.c_str());
}

void writeTruth(const Injector& made) {
  std::FILE* file = std::fopen(made.truth_path.c_str(), "w");
  bool is_written = file != nullptr;
  if (is_written) {
    const std::string text =
        describeTruth(made.order, {made.boards.log(), made.network.log(), made.history.begun(), made.history.packets(),
                                   nowNs() - nowNs(CLOCK_MONOTONIC), nowNs()});
    is_written = std::fputs(text.c_str(), file) >= 0;
    is_written = std::fclose(file) == 0 && is_written;
  }
  if (!is_written) say(made.truth_path + " cannot be written: " + std::strerror(errno));
}

/** Before main(): later calls find the settings there. */
__attribute__((constructor)) void begin() {
  settings();
}

__attribute__((destructor)) void end() {
  const Injector* made = injector.load(std::memory_order_acquire);
  if (made == nullptr || made->truth_path.empty() || made->process != getpid()) return;
  try {
    writeTruth(*made);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "raven2_usb_faults: %s is not written: %s\n", made->truth_path.c_str(), e.what());
  }
}

}  // namespace

Role roleOf(int descriptor) noexcept {
  if (descriptor < 0 || static_cast<std::size_t>(descriptor) >= kDescriptors) return Role::kOther;
  return static_cast<Role>(roles[static_cast<std::size_t>(descriptor)].load(std::memory_order_acquire));
}

Role roleOfSocket(int descriptor) noexcept {
  const Role known = roleOf(descriptor);
  if (known != Role::kUnknown) return known;
  const std::uint16_t port = boundPort(descriptor);
  if (port == 0) return Role::kOther;  // it may be bound later
  const Role role = isItpPort(port) ? Role::kItp : Role::kOther;
  if (role == Role::kItp) decide();
  setRole(descriptor, role);
  return role;
}

void opened(const char* path, int descriptor) noexcept {
  if (descriptor < 0) return;
  const bool is_gold = settings().gold == path;
  if (!is_gold && settings().green != path) {
    setRole(descriptor, Role::kUnknown);
    return warnOfBoard(path);
  }
  decide();
  const Role role = is_gold ? Role::kGold : Role::kGreen;
  setRole(descriptor, role);
  if (roleOf(descriptor) != role) return;
  if (isNoBoardOpen()) numberFrom(armOf(role));
  replace(armOf(role), -1, descriptor);
}

void closed(int descriptor) noexcept {
  const Role role = roleOf(descriptor);
  setRole(descriptor, Role::kUnknown);
  if (isBoard(role)) replace(armOf(role), descriptor, anyOf(role));
}

bool isOn() noexcept {
  return injector.load(std::memory_order_acquire) != nullptr;
}

ssize_t afterRead(Arm arm, ssize_t count, void* buffer, std::size_t size) noexcept {
  Injector* made = injector.load(std::memory_order_acquire);
  raven::UsbInBytes bytes{};
  if (made == nullptr || size < bytes.size()) return count;
  const int error = errno;
  const auto result = static_cast<std::int32_t>(count < 0 ? -error : count);
  if (result == raven::UsbRead::kComplete) std::memcpy(bytes.data(), buffer, bytes.size());
  const std::int32_t faulted = made->boards.read(arm, result, &bytes, nowNs());
  errno = faulted < 0 ? -faulted : error;
  if (faulted == raven::UsbRead::kComplete) std::memcpy(buffer, bytes.data(), bytes.size());
  return faulted < 0 ? -1 : faulted;
}

Delivery beforeWrite(Arm arm, int descriptor, const void* buffer) noexcept {
  at(board_descriptors, arm).store(descriptor, std::memory_order_release);
  Injector* made = injector.load(std::memory_order_acquire);
  Delivery delivery;
  raven::UsbOutBytes bytes;
  std::memcpy(bytes.data(), buffer, bytes.size());
  const BoardFaults::Order order = made->boards.write(arm, bytes, &delivery.bytes);
  if (order.is_written)
    delivery.descriptor = order.board == arm ? descriptor : at(board_descriptors, order.board).load();
  return delivery;
}

void offerPacket(const void* buffer) noexcept {
  wire::ItpBytes bytes;
  std::memcpy(bytes.data(), buffer, bytes.size());
  injector.load(std::memory_order_acquire)->network.offer(bytes, nowNs());
}

bool takePacket(wire::ItpBytes* bytes) noexcept {
  return injector.load(std::memory_order_acquire)->network.take(bytes, nowNs());
}

}  // namespace raven2_trainer::preload
