#include "raven2_trainer/proxy/impairment_proxy.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <sstream>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/stream_socket.h"
#include "raven2_trainer/net/udp_socket.h"

namespace raven2_trainer::proxy {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
const std::string kLoopback = "127.0.0.1";

ProxyOptions linkTo(impair::Medium medium, std::uint16_t port, const Impairment& impairment) {
  ProxyOptions options;
  ProxyLink link;
  link.medium = medium;
  link.target_port = port;
  link.forward = impairment;
  link.back = impairment;
  options.links.push_back(link);
  return options;
}

void serve(ImpairmentProxy* proxy) {
  proxy->serve(net::monotonicNow() + 2 * kMillisecond);
}

/** Serves until the condition holds, which is asked once a round; gives up after so many rounds. */
template <typename Condition>
void serveUntil(ImpairmentProxy* proxy, Condition condition) {
  bool holds = false;
  for (int round = 0; round < 5000 && !holds; ++round) {
    serve(proxy);
    holds = condition();
  }
  ASSERT_TRUE(holds);
}

TEST(ImpairmentProxyTest, DatagramsGoToTheTargetAndAnswersBackToTheSender) {
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kDatagrams, target.port(), {}));
  net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
  const std::uint8_t question[] = {1, 2, 3}, answer[] = {4, 5};
  client.send(question, sizeof(question));
  std::uint8_t buffer[64];
  std::optional<net::Datagram> got;
  serveUntil(&proxy, [&] { return (got = target.receive(buffer, sizeof(buffer))).has_value(); });
  EXPECT_EQ(std::vector<std::uint8_t>(buffer, buffer + got->size), std::vector<std::uint8_t>({1, 2, 3}));
  target.sendTo(got->source, answer, sizeof(answer));
  serveUntil(&proxy, [&] { return (got = client.receive(buffer, sizeof(buffer))).has_value(); });
  EXPECT_EQ(std::vector<std::uint8_t>(buffer, buffer + got->size), std::vector<std::uint8_t>({4, 5}));
}

/** A console that is started again sends from another port. */
TEST(ImpairmentProxyTest, AnswersGoToTheSenderOfTheNewestDatagram) {
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kDatagrams, target.port(), {}));
  std::vector<net::UdpSocket> clients;
  for (std::uint8_t number = 1; number <= 3; ++number) {
    clients.push_back(net::UdpSocket::connected({0x7F000001, proxy.port(0)}));
    clients.back().send(&number, 1);
    std::uint8_t buffer[64] = {};
    std::optional<net::Datagram> got;
    serveUntil(&proxy, [&] { return (got = target.receive(buffer, sizeof(buffer))).has_value(); });
    ASSERT_TRUE(got);
    target.sendTo(got->source, buffer, 1);
    serveUntil(&proxy, [&] { return proxy.report()[1].counts.forwarded == number; });
    EXPECT_TRUE(clients.back().receive(buffer, sizeof(buffer))) << int{number};
  }
}

TEST(ImpairmentProxyTest, TwoLinksLoseDifferentDatagrams) {
  Impairment impairment;
  impairment.loss = 0.5;
  std::array<net::UdpSocket, 2> targets{net::UdpSocket::bound(kLoopback, 0), net::UdpSocket::bound(kLoopback, 0)};
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, targets[0].port(), impairment);
  options.links.push_back(linkTo(impair::Medium::kDatagrams, targets[1].port(), impairment).links[0]);
  ImpairmentProxy proxy(options);
  std::array<std::vector<int>, 2> arrived;
  for (std::size_t link = 0; link < 2; ++link) {
    net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(link)});
    for (std::uint8_t number = 0; number < 200; ++number)
      client.send(&number, 1);
    serveUntil(&proxy, [&] { return proxy.report()[2 * link].counts.in == 200; });
    std::uint8_t byte = 0;
    while (targets[link].receive(&byte, 1))
      arrived[link].push_back(byte);
    EXPECT_NEAR(static_cast<double>(arrived[link].size()), 100.0, 40.0);
  }
  EXPECT_NE(arrived[0], arrived[1]);
}

TEST(ImpairmentProxyTest, TheSameSeedLosesTheSameDatagramsAndTheFiguresAddUp) {
  Impairment impairment;
  impairment.loss = 0.3;
  std::vector<std::vector<int>> arrived(2);
  for (auto& numbers : arrived) {
    net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
    ImpairmentProxy proxy(linkTo(impair::Medium::kDatagrams, target.port(), impairment));
    net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
    for (int i = 0; i < 200; ++i) {
      const auto byte = static_cast<std::uint8_t>(i);
      client.send(&byte, 1);
    }
    std::uint8_t buffer[8];
    serveUntil(&proxy, [&] { return proxy.report()[0].counts.in == 200; });
    while (target.receive(buffer, sizeof(buffer)))
      numbers.push_back(buffer[0]);
    const ProxyReport report = proxy.report()[0];
    EXPECT_TRUE(report.counts.addsUp());
    EXPECT_EQ(report.counts.forwarded, numbers.size());
    EXPECT_EQ(report.unsent, 0U);
  }
  EXPECT_LT(arrived[0].size(), 180U);
  EXPECT_EQ(arrived[0], arrived[1]);
}

TEST(ImpairmentProxyTest, TheLogTellsEveryPacketWithItsSequenceAndWhatIsStillHeld) {
  const auto path = std::filesystem::temp_directory_path() / ("raven2_proxy_" + std::to_string(getpid()) + ".csv");
  Impairment impairment;
  impairment.loss = 0.5;
  impairment.delay.constant_ns = 3600'000 * kMillisecond;
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, target.port(), impairment);
  options.log = path.string();
  ImpairmentProxy proxy(options);
  net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
  std::vector<std::uint8_t> itp(156);
  itp[0] = 77;
  const std::array<std::size_t, 4> sizes{124, 156, 125, 123};  // plain and signed ITP; others have no sequence
  for (std::size_t i = 0; i < 20; ++i)
    client.send(itp.data(), sizes[i % 4]);
  serveUntil(&proxy, [&] { return proxy.report()[0].counts.in == 20; });
  proxy.finish();
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line,
            "link,direction,packet,copy,sequence,bytes,in_ns,action,due_ns,out_ns,flipped_bits,truncated,reordered");
  std::uint64_t lost = 0, held = 0, itp_lines = 0;
  const std::string link = "udp " + std::to_string(proxy.port(0)) + ",forward,";
  while (std::getline(file, line)) {
    EXPECT_EQ(line.rfind(link, 0), 0U) << line;
    const bool is_itp = line.find(",0,77,124,") != std::string::npos || line.find(",0,77,156,") != std::string::npos;
    const bool is_other = line.find(",0,,125,") != std::string::npos || line.find(",0,,123,") != std::string::npos;
    EXPECT_NE(is_itp, is_other) << line;
    itp_lines += is_itp ? 1 : 0;
    lost += line.find(",lost,") != std::string::npos ? 1 : 0;
    held += line.find(",held,") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(lost, proxy.report()[0].counts.droppedTotal());
  EXPECT_EQ(held, proxy.report()[0].counts.held);
  EXPECT_EQ(lost + held, 20U);
  EXPECT_EQ(itp_lines, 10U);
  std::filesystem::remove(path);
}

TEST(ImpairmentProxyTest, AStreamArrivesWholeInBothDirectionsAndItsEndIsPassedOn) {
  Impairment impairment;
  impairment.loss = 0.01;  // costs time, no bytes
  impairment.delay.constant_ns = 3 * kMillisecond;
  impairment.delay.uniform_ns = 2 * kMillisecond;
  net::StreamListener target(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kStream, target.port(), impairment));
  auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
  ASSERT_TRUE(client);
  std::optional<net::StreamSocket> server;
  serveUntil(&proxy, [&] { return (server = target.accept()).has_value(); });

  std::vector<std::uint8_t> sent(2'000'000);
  std::iota(sent.begin(), sent.end(), std::uint8_t{0});
  std::vector<std::uint8_t> got;
  std::size_t done = 0;
  bool ended = false;
  std::vector<std::uint8_t> buffer(65536);
  serveUntil(&proxy, [&] {
    if (done < sent.size()) {
      done += client->send(sent.data() + done, sent.size() - done).count;
      if (done == sent.size()) client->endSending();
    }
    const auto moved = server->receive(buffer.data(), buffer.size());
    got.insert(got.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(moved.count));
    ended = ended || moved.result == net::StreamSocket::Result::kEnd;
    return ended;
  });
  EXPECT_EQ(got, sent);
  const std::uint8_t answer[] = {9, 8, 7};
  server->send(answer, sizeof(answer));
  std::size_t back = 0;
  serveUntil(&proxy, [&] { return (back += client->receive(buffer.data(), buffer.size()).count) == 3; });
  EXPECT_EQ(proxy.report()[0].connections, 1U);
  EXPECT_EQ(proxy.report()[0].counts.droppedTotal(), 0U);
}

TEST(ImpairmentProxyTest, AStreamIsHeldUpByAnOutageAndGoesOnBehindIt) {
  Impairment impairment;
  impairment.outages = {{0, 300 * kMillisecond}};
  net::StreamListener target(kLoopback, 0);
  const std::int64_t start = net::monotonicNow();
  ImpairmentProxy proxy(linkTo(impair::Medium::kStream, target.port(), impairment));
  auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
  std::optional<net::StreamSocket> server;
  serveUntil(&proxy, [&] { return (server = target.accept()).has_value(); });
  const std::uint8_t byte = 1;
  client->send(&byte, 1);
  std::uint8_t buffer[8];
  serveUntil(&proxy, [&] { return server->receive(buffer, sizeof(buffer)).count == 1; });
  EXPECT_GE(net::monotonicNow() - start, 300 * kMillisecond);
}

TEST(ImpairmentProxyTest, ConnectionsThatAreOverStayInTheFigures) {
  net::StreamListener target(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kStream, target.port(), {}));
  std::uint8_t byte = 7;
  for (std::uint64_t number = 1; number <= 3; ++number) {
    auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
    ASSERT_TRUE(client);
    std::optional<net::StreamSocket> server;
    serveUntil(&proxy, [&] { return (server = target.accept()).has_value(); });
    ASSERT_TRUE(server);
    for (net::StreamSocket* end : {&*client, &*server}) {
      end->send(&byte, 1);
      end->endSending();
    }
    for (net::StreamSocket* end : {&*client, &*server}) {
      serveUntil(&proxy, [&] { return end->receive(&byte, 1).count == 1; });
      serveUntil(&proxy, [&] { return end->receive(&byte, 1).result == net::StreamSocket::Result::kEnd; });
    }
    for (const ProxyReport& report : proxy.report()) {
      EXPECT_EQ(report.connections, number);
      EXPECT_EQ(report.counts.in, number) << report.direction;
      EXPECT_EQ(report.counts.forwarded, number) << report.direction;
    }
  }
}

TEST(ImpairmentProxyTest, TheLogHasWhatABrokenConnectionHeld) {
  const auto path = std::filesystem::temp_directory_path() / ("raven2_broken_" + std::to_string(getpid()) + ".csv");
  Impairment slow;
  slow.delay.constant_ns = 3600'000 * kMillisecond;
  net::StreamListener target(kLoopback, 0);
  ProxyOptions options = linkTo(impair::Medium::kStream, target.port(), slow);
  options.links[0].back = {};
  options.log = path.string();
  ImpairmentProxy proxy(options);
  auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
  ASSERT_TRUE(client);
  std::optional<net::StreamSocket> server;
  serveUntil(&proxy, [&] { return (server = target.accept()).has_value(); });
  const std::uint8_t byte = 1;
  client->send(&byte, 1);
  serveUntil(&proxy, [&] { return proxy.report()[0].counts.in == 1; });
  server->send(&byte, 1);
  serveUntil(&proxy, [&] { return proxy.report()[1].counts.forwarded == 1; });
  client.reset();  // it has not read what came, so the connection breaks
  serveUntil(&proxy, [&] { return proxy.report()[0].unsent == 1; });
  EXPECT_TRUE(proxy.report()[0].counts.addsUp());
  EXPECT_EQ(proxy.report()[0].counts.forwarded, 1U);
  proxy.finish();
  std::ifstream file(path);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::string row = "tcp " + std::to_string(proxy.port(0)) + ",forward,0,0,,1,";
  const std::size_t begin = text.find(row);
  ASSERT_NE(begin, std::string::npos) << text;
  EXPECT_NE(text.substr(begin, text.find('\n', begin) - begin).find(",unsent,"), std::string::npos) << text;
  std::filesystem::remove(path);
}

TEST(ImpairmentProxyTest, ALogThatCannotBeWrittenIsReported) {
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, 9, {});
  options.log = "/dev/full";  // it can be opened, but takes nothing
  ImpairmentProxy proxy(options);
  EXPECT_THROW(proxy.finish(), SessionException);
  EXPECT_NO_THROW(proxy.finish()) << "it is reported once";
}

TEST(ImpairmentProxyTest, ATargetThatIsNotThereClosesTheClientsConnection) {
  std::uint16_t free_port = 0;
  { free_port = net::StreamListener(kLoopback, 0).port(); }
  ImpairmentProxy proxy(linkTo(impair::Medium::kStream, free_port, {}));
  auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
  std::uint8_t buffer[8];
  serveUntil(&proxy, [&] {
    const auto result = client->receive(buffer, sizeof(buffer)).result;
    return result == net::StreamSocket::Result::kEnd || result == net::StreamSocket::Result::kError;
  });
}

TEST(ImpairmentProxyTest, APortThatIsTakenIsTold) {
  net::UdpSocket taken = net::UdpSocket::bound(kLoopback, 0);
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, 9, {});
  options.links[0].listen_port = taken.port();
  EXPECT_THROW(ImpairmentProxy{options}, NetworkException);
}

TEST(ImpairmentProxyTest, DatagramsOnTheirWayBackHaveTheirOwnImpairment) {
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, target.port(), {});
  options.links[0].back.loss = 1.0;
  ImpairmentProxy proxy(options);
  net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
  std::uint8_t byte = 1;
  client.send(&byte, 1);
  std::optional<net::Datagram> got;
  serveUntil(&proxy, [&] { return (got = target.receive(&byte, 1)).has_value(); });
  ASSERT_TRUE(got);
  target.sendTo(got->source, &byte, 1);
  serveUntil(&proxy, [&] { return proxy.report()[1].counts.in == 1; });
  EXPECT_EQ(proxy.report()[0].counts.forwarded, 1U);
  EXPECT_EQ(proxy.report()[1].counts.droppedTotal(), 1U);
}

TEST(ImpairmentProxyTest, TheTwoDirectionsLoseDifferentDatagrams) {
  Impairment impairment;
  impairment.loss = 0.5;
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kDatagrams, target.port(), impairment));
  net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
  std::array<std::vector<int>, 2> arrived;
  for (std::uint8_t number = 0; number < 200; ++number)
    client.send(&number, 1);
  serveUntil(&proxy, [&] { return proxy.report()[0].counts.in == 200; });
  std::uint8_t byte = 0;
  std::optional<net::Datagram> last;
  while (const auto got = target.receive(&byte, 1)) {
    last = got;
    arrived[0].push_back(byte);
  }
  ASSERT_TRUE(last);
  for (std::uint8_t number = 0; number < 200; ++number)
    target.sendTo(last->source, &number, 1);
  serveUntil(&proxy, [&] { return proxy.report()[1].counts.in == 200; });
  while (client.receive(&byte, 1))
    arrived[1].push_back(byte);
  EXPECT_NEAR(static_cast<double>(arrived[1].size()), 100.0, 40.0);
  EXPECT_NE(arrived[0], arrived[1]);
}

/** Sends eight bytes, one after the other. @return whether each was held up. */
std::vector<bool> heldUp(ImpairmentProxy* proxy, std::size_t way, net::StreamSocket* from, net::StreamSocket* to) {
  std::vector<bool> held;
  for (std::uint8_t byte = 0; byte < 8; ++byte) {
    const std::uint64_t before = proxy->report()[way].counts.stalled;
    from->send(&byte, 1);
    std::uint8_t got = 0;
    serveUntil(proxy, [&] { return to->receive(&got, 1).count == 1; });
    held.push_back(proxy->report()[way].counts.stalled > before);
  }
  return held;
}

TEST(ImpairmentProxyTest, EachWayAndEachConnectionOfAStreamHasItsOwnLosses) {
  Impairment impairment;
  impairment.loss = 0.5;
  net::StreamListener target(kLoopback, 0);
  ImpairmentProxy proxy(linkTo(impair::Medium::kStream, target.port(), impairment));
  std::vector<std::vector<bool>> all;
  for (int connection = 0; connection < 2; ++connection) {
    auto client = net::StreamSocket::connecting({0x7F000001, proxy.port(0)});
    ASSERT_TRUE(client);
    std::optional<net::StreamSocket> server;
    serveUntil(&proxy, [&] { return (server = target.accept()).has_value(); });
    all.push_back(heldUp(&proxy, 0, &*client, &*server));
    all.push_back(heldUp(&proxy, 1, &*server, &*client));
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(std::count(all[i].begin(), all[i].end(), true)), 4.0, 3.5);
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_NE(all[i], all[k]) << i << k;
  }
}

TEST(ImpairmentProxyTest, TheLogHasTheTimesFromTheStartAndWhatWasSpoilt) {
  const auto path = std::filesystem::temp_directory_path() / ("raven2_times_" + std::to_string(getpid()) + ".csv");
  Impairment impairment;
  impairment.delay.constant_ns = 5 * kMillisecond;
  impairment.corruption.probability = 1.0;
  impairment.corruption.bits = 2;
  net::UdpSocket target = net::UdpSocket::bound(kLoopback, 0);
  ProxyOptions options = linkTo(impair::Medium::kDatagrams, target.port(), impairment);
  options.log = path.string();
  const std::int64_t start = net::monotonicNow();
  ImpairmentProxy proxy(options);
  net::UdpSocket client = net::UdpSocket::connected({0x7F000001, proxy.port(0)});
  std::uint8_t bytes[124] = {};
  client.send(bytes, sizeof(bytes));
  serveUntil(&proxy, [&] { return target.receive(bytes, sizeof(bytes)).has_value(); });
  proxy.finish();
  std::ifstream file(path);
  std::string row, cell;
  std::getline(file, row);
  std::getline(file, row);
  std::vector<std::string> cells;
  for (std::istringstream in(row); std::getline(in, cell, ',');)
    cells.push_back(cell);
  ASSERT_EQ(cells.size(), 13U) << row;
  const std::int64_t in_ns = std::stoll(cells[6]), due_ns = std::stoll(cells[8]), out_ns = std::stoll(cells[9]);
  EXPECT_GE(in_ns, 0);
  EXPECT_EQ(due_ns, in_ns + 5 * kMillisecond);
  EXPECT_GE(out_ns, due_ns);
  EXPECT_LE(out_ns, net::monotonicNow() - start);
  EXPECT_EQ(cells[10] + cells[11] + cells[12], "200") << "two bits, not truncated, not reordered";
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace raven2_trainer::proxy
