// A small control program like raven2's r2_control, without any knowledge of faults. It opens two board files, clears
// them, then obeys commands on stdin. `cycle N`: N times it reads both boards, receives a packet if there is one, makes
// commands from the counts and writes them. `wait`: it waits for one packet, as raven2's network thread does. `look`:
// it opens and closes both boards once more. It prints the results of its calls, one line for each cycle.
//
//   usb_control_loop GOLD GREEN PORT

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>

#include "support/allocation_counter.h"

namespace {

#ifdef RAVEN2_COUNTS_ALLOCATIONS
void watch(bool is_watched) {
  raven2_trainer::testing::counting = is_watched;
}
int watched() {
  return raven2_trainer::testing::calls + raven2_trainer::testing::locks;
}
#else
void watch(bool) {}
int watched() {
  return 0;
}
#endif

constexpr std::size_t kIn = 27, kOut = 19, kItp = 124;
constexpr int kChannels = 8;

struct Board {
  int descriptor{-1};
  std::array<std::uint8_t, kIn> in{};
  std::array<std::uint8_t, kOut> out{};
  std::array<std::int32_t, kChannels> counts{};
  std::uint8_t pins{};
};

std::string hex(const std::uint8_t* bytes, std::size_t size) {
  std::string text;
  char digits[3];
  for (std::size_t i = 0; i < size; ++i) {
    std::snprintf(digits, sizeof(digits), "%02x", static_cast<unsigned>(bytes[i]));
    text += digits;
  }
  return text.empty() ? "-" : text;
}

/** raven2 USB_init.cpp: a failed call returns its negative error. */
long orError(ssize_t result) {
  return result < 0 ? -errno : static_cast<long>(result);
}

/** Takes pins and counts from a packet of encoders. After another packet or a failed read the old values stay. */
void take(Board* board, long result) {
  if (result != static_cast<long>(kIn) || board->in[0] != 0x03 || board->in[1] != kChannels) return;
  board->pins = board->in[2];
  for (std::size_t k = 0; k < kChannels; ++k) {
    const std::uint8_t* p = board->in.data() + 3 + 3 * k;
    const std::uint32_t raw = p[0] | static_cast<std::uint32_t>(p[1]) << 8U | static_cast<std::uint32_t>(p[2]) << 16U;
    board->counts[k] = static_cast<std::int32_t>(raw << 8U) >> 8;
  }
}

/** Makes commands within +-2500 from the counts, and puts the run level of the boards' pins on the output pins. */
void command(Board* board, std::uint8_t level) {
  board->out[0] = 0x06;
  board->out[1] = kChannels;
  for (std::size_t k = 0; k < kChannels; ++k) {
    const auto dac = static_cast<std::uint32_t>(board->counts[k] % 2501 + 0x8000);
    board->out[2 + 2 * k] = static_cast<std::uint8_t>(dac & 0xFFU);
    board->out[3 + 2 * k] = static_cast<std::uint8_t>(dac >> 8U & 0xFFU);
  }
  board->out[kOut - 1] = level;
}

/** Hides the size from the compiler, so that it calls the checked forms of read and recvfrom. */
std::size_t atRunTime(std::size_t size) {
  volatile std::size_t hidden = size;
  return hidden;
}

void cycle(Board* gold, Board* green, int socket) {
  watch(true);
  const long read_gold = orError(read(gold->descriptor, gold->in.data(), kIn));
  take(gold, read_gold);
  std::array<std::uint8_t, kIn> buffer{};
  const long read_green = orError(read(green->descriptor, buffer.data(), atRunTime(kIn)));
  if (read_green > 0) green->in = buffer;
  take(green, read_green);
  std::array<std::uint8_t, kItp> packet{};
  const long received = orError(recvfrom(socket, packet.data(), packet.size(), MSG_DONTWAIT, nullptr, nullptr));
  const auto level = static_cast<std::uint8_t>(std::min(gold->pins >> 6, green->pins >> 6));
  command(gold, level);
  command(green, level);
  const long wrote_gold = orError(write(gold->descriptor, gold->out.data(), kOut));
  const long wrote_green = orError(write(green->descriptor, green->out.data(), kOut));
  watch(false);
  std::printf("%ld %s %ld %s %ld %s %ld %s %ld %s\n", read_gold, hex(gold->in.data(), read_gold > 0 ? kIn : 0).c_str(),
              read_green, hex(green->in.data(), read_green > 0 ? kIn : 0).c_str(), received,
              hex(packet.data(), received > 0 ? kItp : 0).c_str(), wrote_gold, hex(gold->out.data(), kOut).c_str(),
              wrote_green, hex(green->out.data(), kOut).c_str());
}

/** raven2 network_layer.cpp:206-235 */
void waitForPacket(int socket) {
  fd_set set;
  FD_ZERO(&set);
  FD_SET(socket, &set);
  timeval patience{10, 0};
  std::array<std::uint8_t, kItp> packet{};
  sockaddr_in from{};
  socklen_t from_size = sizeof(from);
  if (select(socket + 1, &set, nullptr, nullptr, &patience) != 1) {
    std::printf("nothing\n");
    return;
  }
  const long received = orError(
      recvfrom(socket, packet.data(), atRunTime(packet.size()), 0, reinterpret_cast<sockaddr*>(&from), &from_size));
  std::printf("%ld %s %d\n", received, hex(packet.data(), kItp).c_str(), ntohs(from.sin_port));
}

int openBoard(const char* path, Board* board) {
  board->descriptor = open(path, O_RDWR | O_NONBLOCK | O_NOCTTY);
  if (board->descriptor < 0) return 1;
  std::array<std::uint8_t, kOut> zeros{0x06, kChannels};
  return orError(write(board->descriptor, zeros.data(), zeros.size())) == static_cast<long>(kOut) ? 0 : 1;
}

/** Opens and closes a board, like a program that checks whether the boards are present. */
void look(const char* path) {
  const int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY);
  std::printf("%s\n", descriptor >= 0 && close(descriptor) == 0 ? "there" : "not there");
}

int openSocket(const char* port) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(std::atoi(port)));
  return bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0 ? socket : -1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  Board gold, green;
  const int socket = openSocket(argv[3]);
  if (socket < 0 || openBoard(argv[1], &gold) != 0 || openBoard(argv[2], &green) != 0) {
    std::perror("usb_control_loop");
    return 1;
  }
  std::printf("ready\n");
  std::fflush(stdout);
  std::string word;
  while (std::cin >> word) {
    int count = 0;
    if (word == "cycle" && std::cin >> count) {
      for (int i = 0; i < count; ++i)
        cycle(&gold, &green, socket);
    } else if (word == "wait") {
      waitForPacket(socket);
    } else if (word == "look") {
      look(argv[1]);
      look(argv[2]);
    } else {
      break;
    }
    std::fflush(stdout);
  }
  close(gold.descriptor);
  close(green.descriptor);
  std::printf("%d allocations or locks\n", watched());
  return 0;
}
