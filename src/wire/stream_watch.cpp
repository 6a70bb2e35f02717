#include "raven2_trainer/wire/stream_watch.h"

#include <algorithm>

namespace raven2_trainer::wire {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]

const char* remedy(Reject reason) {
  switch (reason) {
    case Reject::kWrongSize:
      return "they are not 124 bytes long: this is not ITP, or its sender pads it (doc/wire.md)";
    case Reject::kNotFinite:
    case Reject::kBadQuaternion:
      return "their rotations are no unit quaternions: a console that sends counts needs a profile (stream in "
             "network.yaml, doc/streams.md)";
    case Reject::kOutOfRange:
      return "they ask for more than max_increment_um, max_rotation or the jaws' range at once: a console with other "
             "units "
             "or an absolute grasp needs a profile (stream in network.yaml, doc/streams.md)";
    case Reject::kForeignSource:
      return "another master is heard, or the pedal was down at the first packet: end the other, or lift the pedal "
             "once";
    case Reject::kDuplicate:
    case Reject::kOutOfOrder:
    case Reject::kSequenceGap:
    case Reject::kSequenceJump:
    case Reject::kSequenceZero:
    case Reject::kReset:
      return "their sequence numbers do not count up by one";
    case Reject::kRateLimited:
      return "there are more a second than max_rate of network.yaml";
    case Reject::kUnsigned:
      return "they are not signed, and network.yaml's auth asks for signatures (make_key, key_file)";
    case Reject::kBadFrame:
    case Reject::kBadSignature:
    case Reject::kReplayed:
    case Reject::kOtherSession:
      return "their signatures are of another key or session: both ends need the same key_file";
    default:
      return "see packets.master_to_daemon in metrics.json";
  }
}

}  // namespace

bool StreamWatch::look(const LinkCounts& counts, std::int64_t now_ns) noexcept {
  if (began_ns_ < 0) began_ns_ = now_ns;
  if (now_ns - began_ns_ < kSecond) return false;
  const std::uint64_t received = counts.received - before_.received, applied = counts.applied - before_.applied;
  const std::uint64_t refused = received - applied;
  std::size_t most = 1;
  for (std::size_t i = 1; i < kRejectCount; ++i) {
    if (counts.rejected[i] - before_.rejected[i] > counts.rejected[most] - before_.rejected[most]) most = i;
  }
  before_ = counts;
  began_ns_ = now_ns;
  const bool is_bad = received >= kFewest && 2 * refused > received;
  may_publish_ = may_publish_ || (received >= kFewest && !is_bad);
  const auto reason = static_cast<Reject>(most);
  const bool is_new = is_bad && (may_publish_ || reason != finding_.reason);
  const std::uint8_t lasts = is_bad ? 1 : 0;
  const bool has_changed = is_new || lasts != finding_.lasts;
  if (is_new) {
    finding_ = {finding_.number + 1, static_cast<std::uint32_t>(received), static_cast<std::uint32_t>(refused), reason,
                1};
    may_publish_ = false;
  }
  finding_.lasts = lasts;
  return has_changed;
}

std::string sentence(const StreamFinding& finding) {
  return "master console: " + std::to_string(finding.refused) + " of " + std::to_string(finding.received) +
         " packets were refused within a second, most as " +
         kRejectNames[std::min(static_cast<std::size_t>(finding.reason), kRejectCount - 1)] + ": " +
         remedy(finding.reason);
}

}  // namespace raven2_trainer::wire
