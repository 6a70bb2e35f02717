// Floods a UDP port of this computer: 124-byte datagrams by sendmmsg, as fast as one core gives. For the system tests.
//   flood PORT SECONDS    prints how many a second the kernel accepted

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<std::uint16_t>(std::atoi(argv[1])));
  std::array<std::uint8_t, 124> bytes{};
  iovec part{bytes.data(), bytes.size()};
  std::array<mmsghdr, 256> messages{};
  for (mmsghdr& message : messages) {
    message.msg_hdr.msg_name = &to;
    message.msg_hdr.msg_namelen = sizeof(to);
    message.msg_hdr.msg_iov = &part;
    message.msg_hdr.msg_iovlen = 1;
  }
  const auto start = std::chrono::steady_clock::now();
  const std::chrono::duration<double> wanted(std::atof(argv[2]));
  long long sent = 0;
  std::chrono::duration<double> elapsed{};
  while (elapsed < wanted) {
    const int n = ::sendmmsg(fd, messages.data(), messages.size(), 0);
    if (n > 0) sent += n;
    elapsed = std::chrono::steady_clock::now() - start;
  }
  std::printf("%.0f\n", static_cast<double>(sent) / elapsed.count());
  ::close(fd);
  return 0;
}
