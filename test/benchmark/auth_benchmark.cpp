// Cost of signed ITP for each packet: to sign, to verify, the whole gate, and BLAKE2b alone. Counts allocations too.

#include <sodium.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <vector>

#include "raven2_trainer/wire/itp_gate.h"
#include "raven2_trainer/wire/signed_sender.h"
#include "support/allocation_counter.h"

namespace raven2_trainer {
namespace {

constexpr int kRounds = 200000;

/** [ns] p50 and p99 of single calls, less the cost of reading the clock. */
template <typename Body>
double measure(const char* what, double unit, Body body) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> ns(kRounds), clock(kRounds);
  for (int i = 0; i < kRounds; ++i) {
    const auto start = Clock::now();
    const auto middle = Clock::now();
    body(i);
    const auto end = Clock::now();
    clock[static_cast<std::size_t>(i)] = std::chrono::duration<double, std::nano>(middle - start).count();
    ns[static_cast<std::size_t>(i)] = std::chrono::duration<double, std::nano>(end - middle).count();
  }
  std::sort(ns.begin(), ns.end());
  std::sort(clock.begin(), clock.end());
  const double p50 = ns[kRounds / 2] - clock[kRounds / 2], p99 = ns[kRounds * 99 / 100] - clock[kRounds / 2];
  const int calls = testing::allocatorCalls([&] { body(kRounds); });
  std::printf("%-28s %8.0f %8.0f %10.2f %12d\n", what, p50, p99, unit > 0.0 ? p50 / unit : 1.0, calls);
  return p50;
}

}  // namespace
}  // namespace raven2_trainer

int main() {
  using namespace raven2_trainer;
  using namespace raven2_trainer::wire;
  std::array<std::uint8_t, ItpKey::kSize> bytes;
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  const ItpKey key(bytes);
  const ItpSession session(key, Audience::kDaemon, Nonce{}, Nonce{});
  const ItpBytes itp = encodeItp(ItpPacket{});
  std::array<std::uint8_t, 16> tag;
  unsigned sum = 0;
  std::printf("%-28s %8s %8s %10s %12s   %d calls\n", "", "p50 ns", "p99 ns", "BLAKE2b", "allocations", kRounds);
  const double unit = measure("BLAKE2b keyed, 124 bytes", 0.0, [&](int) {
    crypto_generichash(tag.data(), tag.size(), itp.data(), itp.size(), key.data(), ItpKey::kSize);
    sum += tag[0];
  });
  measure("sign", unit, [&](int i) { sum += session.sign(itp, static_cast<std::uint64_t>(i))[155]; });
  const SignedItpBytes good = session.sign(itp, 1);
  measure("verify", unit, [&](int) { sum += session.verify(good.data()) ? 1U : 0U; });

  ItpRules rules;
  rules.auth = ItpAuth::kRequired;
  rules.max_rotation = 0.1;
  rules.max_rate = 1e6;
  rules.max_burst = 10000;
  ItpGate gate(rules, Audience::kDaemon, &key);
  SignedSender sender(&key, Audience::kDaemon);
  HandshakeBytes reply;
  const HandshakeBytes hello = sender.hello(Nonce{}, 0);
  if (gate.answer({hello.data(), hello.size(), 1, 0}, Nonce{}, &reply) != Reject::kNone) return 1;
  if (!sender.receive(reply.data(), reply.size(), 0)) return 1;
  std::uint64_t applied = 0;
  ItpPacket packet;
  std::vector<SignedItpBytes> stream(kRounds + 1);
  for (SignedItpBytes& datagram : stream)
    datagram = sender.sign(itp, false);
  measure("gate, one signed packet", unit, [&](int i) {
    const SignedItpBytes& datagram = stream[static_cast<std::size_t>(i)];
    const Arrival arrival{datagram.data(), datagram.size(), 1, i * 1000000LL};
    applied += gate.judge(arrival, &packet) == Reject::kNone ? 1U : 0U;
  });
  std::printf("%llu of %d used (sum %u)\n", static_cast<unsigned long long>(applied), kRounds + 1, sum);
  return applied == kRounds + 1 ? 0 : 1;
}
