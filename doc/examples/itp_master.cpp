// The smallest master: pedal up for half a second, then down while both tools draw a circle. doc/wire.md has the
// packet.
//   c++ -o itp_master itp_master.cpp && ./itp_master [HOST] [PORT] [SECONDS]    defaults: 127.0.0.1, 36010, 10 s
#include <arpa/inet.h>
#include <sys/socket.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <thread>

#pragma pack(push, 1)
struct Itp {  // little-endian, 124 bytes; [0] gold, [1] green
  std::uint32_t sequence{}, pactyp{}, version{};
  std::int32_t delx[2]{}, dely[2]{}, delz[2]{};  // [um] x forward, y right, z down
  double Qx[2]{}, Qy[2]{}, Qz[2]{}, Qw[2]{1.0, 1.0};
  std::int32_t buttonstate[2]{}, grasp[2]{}, surgeon_mode{}, checksum{};
};
#pragma pack(pop)
static_assert(sizeof(Itp) == 124, "packed");

int main(int argc, char** argv) {
  sockaddr_in target{};
  target.sin_family = AF_INET;
  target.sin_port = htons(static_cast<std::uint16_t>(argc > 2 ? std::atoi(argv[2]) : 36010));
  if (inet_pton(AF_INET, argc > 1 ? argv[1] : "127.0.0.1", &target.sin_addr) != 1) return 1;
  const int sock = socket(AF_INET, SOCK_DGRAM, 0);
  const double seconds = argc > 3 ? std::atof(argv[3]) : 10.0;
  const auto start = std::chrono::steady_clock::now();
  std::int32_t x = 0, y = 0;  // [um] sent so far: differences of whole positions round nothing away
  for (int n = 1; n <= static_cast<int>(1000.0 * seconds); ++n) {
    const double angle = 2.0 * 3.14159265358979 * std::fmax(n / 1000.0 - 0.5, 0.0) / 5.0;  // 5 s, radius 5 mm
    const auto now_x = static_cast<std::int32_t>(std::lround(5000.0 * std::sin(angle)));
    const auto now_y = static_cast<std::int32_t>(std::lround(5000.0 * (1.0 - std::cos(angle))));
    Itp packet;
    packet.sequence = static_cast<std::uint32_t>(n);
    packet.surgeon_mode = n > 500 ? 1 : 0;
    packet.delx[0] = packet.delx[1] = now_x - x;
    packet.dely[0] = packet.dely[1] = now_y - y;
    packet.checksum = packet.surgeon_mode + 2 * (now_x - x) + 2 * (now_y - y) + n;
    x = now_x;
    y = now_y;
    sendto(sock, &packet, sizeof(packet), 0, reinterpret_cast<const sockaddr*>(&target), sizeof(target));
    std::this_thread::sleep_until(start + std::chrono::milliseconds(n));
  }
}
