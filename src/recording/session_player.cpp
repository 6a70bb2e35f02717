#include "raven2_trainer/recording/session_player.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <optional>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::recording {
namespace {

// A CRC does not show whether values are sensible. They are put into the world, which would stop for ever at NaN or
// infinity. Joints rotate by less than 1.5 revolutions.
constexpr double kLargestJoint = 10.0;  // [rad; m]
constexpr double kFarthest = 1e6;       // [m] a body that fell off the scene for minutes is nearer
constexpr double kNormTolerance = 0.02;

bool isSmall(double value, double limit) noexcept {
  return std::abs(value) <= limit;  // and a number
}

bool isPose(const RigidPose& pose) noexcept {
  double squares = 0.0;
  for (const double x : pose.q)
    squares += x * x;
  bool is_there = isSmall(std::sqrt(squares) - 1.0, kNormTolerance);
  for (const double x : pose.p)
    is_there = is_there && isSmall(x, kFarthest);
  return is_there;
}

bool canBe(const ReplayFrame& frame) noexcept {
  for (const JointArray& q : frame.q) {
    for (const double x : q) {
      if (!isSmall(x, kLargestJoint)) return false;
    }
  }
  for (const RigidPose& pose : frame.bodies_W) {
    if (!isPose(pose)) return false;
  }
  return true;
}

ReplayFrame frameOf(const ModelState& model, std::uint32_t replay) noexcept {
  ReplayFrame frame;
  frame.replay = replay;
  for (const Arm arm : kArms)
    at(frame.q, arm) = at(model.arms, arm).q;
  frame.bodies_W = model.bodies;
  return frame;
}

std::string logOf(const std::string& path) {
  std::error_code none;
  return std::filesystem::is_directory(path, none) ? session::SessionPaths{path}.log() : path;
}

}  // namespace

struct SessionPlayer::Impl {
  void check(const session::LogHeader& header, const std::string& log) const {
    const bool same_arms =
        header.robot_urdf_hash == session::fileHash(config.robot_urdf) && header.d4 == config.arms.geometry.d4;
    if (!same_arms) throw SessionException(log + ": was recorded with other arms than this session's");
    if (header.scene_urdf_hash != session::fileHash(config.scene_urdf) || header.body_names != body_names)
      throw SessionException(log + ": was recorded in another scene than this session's");
  }

  /** The next tick that can be shown. @return false behind the last one. */
  bool read(ReplayFrame* frame) {
    TickRecord record;
    while (reader->position() < size && reader->next(&record)) {
      *frame = frameOf(record.model, replay);
      if (record.model.session_tick >= 0 && canBe(*frame)) return true;
    }
    return false;
  }

  bool hasRoom() const {
    const RingCounts counts = shared.replay_frames.counts();
    return counts.pushed - counts.taken < kReplayFrames;
  }

  /** A disk that fails in the midst of it ends it. */
  bool readOrEnd(ReplayFrame* frame) {
    try {
      return read(frame);
    } catch (const SessionException& e) {
      std::fprintf(stderr, "%s: what is shown of it ends here\n", e.what());
      return false;
    }
  }

  void fill() {
    while (reader && hasRoom()) {
      ReplayFrame frame = first ? *first : ReplayFrame{};
      const bool is_there = first.has_value() || readOrEnd(&frame);
      first.reset();
      if (!is_there) {
        frame.replay = replay;
        frame.is_last = 1;
        reader.reset();
      }
      shared.replay_frames.tryPush(frame);
    }
  }

  const TrainerConfig& config;
  const std::vector<std::string> body_names;
  SharedState& shared;
  std::mutex mutex;  // between open() and serve()
  std::optional<session::TickReader> reader;
  std::optional<ReplayFrame> first;  // read when it was opened
  std::uintmax_t size{0};            // [bytes] of the log then
  std::uint32_t replay{0};
};

SessionPlayer::SessionPlayer(const TrainerConfig& config, std::vector<std::string> body_names, SharedState* shared)
    : impl_(new Impl{config, std::move(body_names), *shared, {}, {}, {}, 0, 0}) {}

SessionPlayer::~SessionPlayer() = default;

std::uint32_t SessionPlayer::open(const std::string& path) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  Impl& s = *impl_;
  const std::string log = logOf(path);
  s.reader.reset();
  s.first.reset();
  if (++s.replay == 0) s.replay = 1;
  try {
    if (std::filesystem::exists(log) && !std::filesystem::is_regular_file(log))
      throw SessionException(log + ": is no file");  // opening a pipe would wait
    s.reader.emplace(log);
    s.check(s.reader->header(), log);
    s.size = std::filesystem::file_size(log);
    ReplayFrame frame;
    if (!s.read(&frame)) throw SessionException(log + ": no pedal went down in it, there is nothing to show");
    s.first = frame;
  } catch (const std::exception& e) {
    s.reader.reset();
    throw SessionException(e.what());
  }
  s.fill();
  return s.replay;
}

void SessionPlayer::serve() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->fill();
}

}  // namespace raven2_trainer::recording
