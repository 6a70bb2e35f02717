#pragma once

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/wire/itp_gate.h"
#include "raven2_trainer/wire/itp_rules.h"
#include "raven2_trainer/wire/signed_sender.h"

namespace raven2_trainer::wire {

inline const ItpKey& benchKey() {
  static const ItpKey key([] {
    std::array<std::uint8_t, ItpKey::kSize> bytes;
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{100});
    return bytes;
  }());
  return key;
}

/** Figures of config/network.yaml. */
inline ItpRules benchRules(bool hardened, ItpAuth auth) {
  ItpRules rules;
  rules.hardened = hardened;
  rules.auth = auth;
  rules.max_increment_um = 5000;
  rules.max_rotation = 0.1;
  rules.max_rate = 1200;
  rules.max_burst = 40;
  rules.master_timeout = 0.2;
  rules.compat_timeout = 5.0;
  return rules;
}

/** A gate, its honest surgeon, who sends a packet a millisecond, and other senders that can reach the port. */
class GateBench {
 public:
  static constexpr std::uint64_t kSurgeon = 0x7F0000018CA0;  // address << 16 | port
  static constexpr std::uint64_t kOther = 0x7F0000018CA1;

  GateBench(bool hardened, ItpAuth auth)
      : gate(benchRules(hardened, auth), Audience::kDaemon, &benchKey()), is_signed(auth != ItpAuth::kOff) {
    if (is_signed) shakeHands(&sender, kSurgeon);
    for (int i = 0; i < 5; ++i)
      surgeon(false);
  }

  Nonce fresh() {
    Nonce nonce;
    for (std::uint8_t& byte : nonce)
      byte = static_cast<std::uint8_t>(random.next());
    return nonce;
  }

  bool shakeHands(SignedSender* who, std::uint64_t source) {
    const HandshakeBytes hello = who->hello(fresh(), now_ns);
    HandshakeBytes reply;
    if (gate.answer({hello.data(), hello.size(), source, now_ns}, fresh(), &reply) != Reject::kNone) return false;
    return who->receive(reply.data(), reply.size(), now_ns);
  }

  ItpPacket packet(std::uint32_t number, bool pedal, std::int32_t um = 100) const {
    ItpPacket p;
    p.sequence = number;
    p.delx_um[0] = um;
    p.surgeon_mode = pedal ? 1 : 0;
    p.checksum = itpChecksum(p);
    return p;
  }

  /** The surgeon's next datagram. */
  std::vector<std::uint8_t> next(bool pedal, std::int32_t um = 100) {
    const ItpBytes itp = encodeItp(packet(++sequence, pedal, um));
    if (!is_signed) return {itp.begin(), itp.end()};
    const SignedItpBytes bytes = sender.sign(itp, pedal);
    return {bytes.begin(), bytes.end()};
  }

  Reject arrive(const std::vector<std::uint8_t>& bytes, std::uint64_t source) {
    const Reject reason = gate.judge({bytes.data(), bytes.size(), source, now_ns}, &last_used);
    counts.count(reason);
    return reason;
  }

  /** A millisecond passes, the surgeon's packet arrives. */
  Reject surgeon(bool pedal = true) {
    now_ns += kTickNanoseconds;
    gate.idle(now_ns);
    return arrive(next(pedal), kSurgeon);
  }

  /** How many of the surgeon's next n packets are used. */
  int surgeonUsed(int n) {
    int used = 0;
    for (int i = 0; i < n; ++i)
      used += surgeon() == Reject::kNone ? 1 : 0;
    return used;
  }

  /** A packet forged without the key. The attacker knows the wanted packet, and the packets on the wire. */
  std::vector<std::uint8_t> forged(const ItpPacket& p, const std::vector<std::uint8_t>& captured) const {
    const ItpBytes itp = encodeItp(p);
    std::vector<std::uint8_t> bytes(itp.begin(), itp.end());
    if (is_signed && captured.size() == kSignedItpSize) {
      bytes.insert(bytes.end(), captured.begin() + static_cast<std::ptrdiff_t>(kItpSize), captured.end());
      for (std::size_t i = 0; i < 8; ++i)  // a counter of the future, for the window
        bytes[kItpSize + 8 + i] = i == 3 ? 1 : bytes[kItpSize + 8 + i];
    }
    return bytes;
  }

  ItpGate gate;
  bool is_signed;
  SignedSender sender{&benchKey(), Audience::kDaemon};
  Random random{11};
  std::int64_t now_ns{1'000'000'000};
  std::uint32_t sequence{5000};
  ItpPacket last_used;
  LinkCounts counts;
};

}  // namespace raven2_trainer::wire
