#include "daemon/master_port.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <memory>
#include <string>

#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/net/file_descriptor.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/wire/itp.h"
#include "support/rig.h"

namespace raven2_trainer::daemon {
namespace {

/** Sends a master's first packet from this loopback address. */
void sendFrom(const std::string& address, std::uint16_t port) {
  const net::FileDescriptor fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in own{}, to{};
  own.sin_family = to.sin_family = AF_INET;
  own.sin_addr.s_addr = ::inet_addr(address.c_str());
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(port);
  ASSERT_EQ(::bind(fd.get(), reinterpret_cast<const sockaddr*>(&own), sizeof(own)), 0);
  wire::ItpPacket packet;
  packet.sequence = 1;
  const wire::ItpBytes bytes = wire::encodeItp(packet);
  ASSERT_EQ(::sendto(fd.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to)),
            static_cast<ssize_t>(bytes.size()));
}

TEST(MasterPort, HearsTheConfiguredMasterAlone) {
  for (const std::string& allowed : {std::string(), std::string("127.0.0.2")}) {
    NetworkConfig network = raven2_trainer::testing::packagedConfig().network;
    network.bind_address = "127.0.0.1";
    network.master_address = allowed;
    network.master_port = net::UdpReceiver("127.0.0.1", 0).port();
    const auto shared = std::make_unique<SharedState>();
    MasterPort port(network, nullptr, shared.get());
    sendFrom("127.0.0.1", network.master_port);
    port.tick();
    const LinkCounts counts = shared->master_link.load();
    EXPECT_EQ(counts.applied, allowed.empty() ? 1U : 0U);
    EXPECT_EQ(counts.rejected[static_cast<std::size_t>(Reject::kForeignSource)], allowed.empty() ? 0U : 1U);
    if (allowed.empty()) continue;
    sendFrom(allowed, network.master_port);
    port.tick();
    EXPECT_EQ(shared->master_link.load().applied, 1U);
  }
}

}  // namespace
}  // namespace raven2_trainer::daemon
