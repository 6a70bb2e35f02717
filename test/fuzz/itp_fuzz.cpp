#include "raven2_trainer/wire/itp_gate.h"

#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/core/command.h"

// The daemon's ingest, hardened, plain and signed: a stream of datagrams, judged one by one.
// Input: for each datagram a byte, then its bytes. If the byte is even, the size is 124; if odd, the upper bits give
// the size. The byte also gives the time since the last datagram, up to 31 ms, and one of two senders.

namespace raven2_trainer::fuzz {
namespace {

constexpr std::int32_t kMaxIncrementUm = 20000;

bool isFinite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void requireSane(const MasterCommand& command) {
  for (const Arm arm : kArms) {
    require(isFinite(at(command.dp_I, arm)), "an applied increment is finite");
    for (const double x : at(command.dp_I, arm))
      require(std::abs(x) <= kMaxIncrementUm * 1e-6, "an applied increment is within the limit");
    const Quat& q = at(command.dq_I, arm);
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    require(std::abs(norm - 1.0) < 1e-9, "an applied rotation is a unit quaternion");
    require(std::abs(at(command.dgrasp, arm)) <= 1.745, "an applied grasp is within the jaws");
  }
  require(command.pedal <= 1, "the pedal is up or down");
}

/** Decoding loses no information. */
void requireRoundTrip(const wire::ItpPacket& packet, const Bytes& bytes) {
  const wire::ItpBytes again = wire::encodeItp(packet);
  require(std::memcmp(again.data(), bytes.data(), again.size()) == 0, "encoding gives the bytes decoded");
}

ItpRules rules(ItpAuth auth) {
  ItpRules r;
  r.auth = auth;
  r.max_increment_um = kMaxIncrementUm;
  r.max_rotation = 3.2;
  r.max_rate = 1200.0;
  r.max_burst = 40;
  r.master_timeout = 0.2;
  r.compat_timeout = 5.0;
  return r;
}

const wire::ItpKey& key() {
  static const wire::ItpKey value(std::array<std::uint8_t, wire::ItpKey::kSize>{1, 2, 3});
  return value;
}

/** One receiver. If signed ITP is required, it accepts no packet from a sender without the key. */
class Ingest {
 public:
  explicit Ingest(ItpAuth auth) : auth_(auth), gate_(rules(auth), wire::Audience::kDaemon, &key()) {}

  void receive(const Bytes& bytes, std::uint8_t kind) {
    time_ns_ += (kind >> 3U) * 1'000'000;
    gate_.idle(time_ns_);
    const wire::Arrival arrival{bytes.data(), bytes.size(), 1U + (kind >> 1U & 1U), time_ns_};
    if (gate_.isHello(arrival)) return answer(arrival);
    wire::ItpPacket packet;
    const std::uint32_t before = gate_.last();
    const Reject reason = gate_.judge(arrival, &packet);
    counts_.count(reason);
    require(counts_.addsUp(), "received = applied + rejected");
    require(gate_.last() == before || reason == Reject::kNone || reason == Reject::kReset,
            "a rejected packet does not move the window");
    if (reason != Reject::kNone) return;
    require(auth_ == ItpAuth::kOff, "nothing unsigned is used");
    requireRoundTrip(packet, bytes);
    requireSane(wire::toCommand(packet));
  }

 private:
  void answer(const wire::Arrival& arrival) {
    wire::HandshakeBytes reply;
    wire::Nonce fresh{};
    fresh[0] = ++nonce_;
    if (gate_.answer(arrival, fresh, &reply) == Reject::kNone) require(auth_ != ItpAuth::kOff, "no key, no answer");
  }

  ItpAuth auth_;
  wire::ItpGate gate_;
  std::int64_t time_ns_{1'000'000'000};
  std::uint8_t nonce_{0};
  LinkCounts counts_{};
};

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static fuzz::MessageCount datagrams;
  fuzz::Input input(data, size);
  fuzz::Ingest plain(ItpAuth::kOff), guarded(ItpAuth::kRequired);
  while (!input.empty()) {
    const std::uint8_t kind = input.byte();
    const fuzz::Bytes bytes = input.take((kind & 1U) == 0 ? wire::kItpSize : kind / 2U);
    ++datagrams;
    plain.receive(bytes, kind);
    guarded.receive(bytes, kind);
  }
  return 0;
}
