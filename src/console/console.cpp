#include "raven2_trainer/console/console.h"

#include <algorithm>
#include <cmath>

#include "increment.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/haptics/hand_model.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {
namespace {

constexpr double kMicrometresPerMetre = 1e6;
constexpr double kMilliradiansPerRadian = 1e3;
constexpr double kMaxForce = 20.0;   ///< [N] far above any such device (the Omni's peak is 3.3 N): what came is broken
constexpr int kSightLifetime = 500;  ///< [ticks] after so long without a picture their numbers may start again
constexpr int kForceLifetime = 50;   ///< [ticks] a force not renewed is gone (sources.md 2.2)

/** Whether a number is to be taken after the newest one, which still counts. */
Reject order(std::uint32_t sequence, std::uint32_t newest) noexcept {
  if (sequence == newest) return Reject::kDuplicate;
  return static_cast<std::int32_t>(sequence - newest) < 0 ? Reject::kOutOfOrder : Reject::kNone;
}

bool isPlausible(const ForcePacket& packet) noexcept {
  for (const Vec3& force : packet.force_I) {
    for (const double f : force) {
      if (!(std::abs(f) <= kMaxForce)) return false;
    }
  }
  return true;
}

bool isFinite(const RigidPose& pose) noexcept {
  return toEigen(pose.p).allFinite() && std::isfinite(toEigen(pose.q).norm()) && toEigen(pose.q).norm() > 0.5;
}

bool isPlausible(const Sight& sight) noexcept {
  const auto all = [](const auto& poses) { return std::all_of(poses.begin(), poses.end(), isFinite); };
  return all(sight.tool_W) && all(sight.bodies_W) && std::isfinite(sight.opening[0]) && std::isfinite(sight.opening[1]);
}

}  // namespace

struct Console::Impl {
  /** One hand, its master and what it has sent. */
  struct Master {
    explicit Master(const ConsoleConfig& config) : hand(config) {}
    haptics::HandModel hand;
    std::array<Increment, 3> position;
    TurnIncrement turn;
    Increment grasp;
  };

  Impl(const ConsoleConfig& console_config, std::unique_ptr<MotionSource> motion)
      : config(console_config),
        source(std::move(motion)),
        is_real(source->isReal()),
        masters{Master(config), Master(config)} {}

  bool mayMove() noexcept;
  Vector3 forceOn(Arm arm) const noexcept;
  void feel() noexcept;
  void move(wire::ItpPacket* packet);
  void moveMaster(Arm arm, bool counts, wire::ItpPacket* packet) noexcept;
  void turnMaster(Arm arm, bool counts, wire::ItpPacket* packet) noexcept;

  const ConsoleConfig config;
  std::unique_ptr<MotionSource> source;
  const bool is_real;
  PerArm<Master> masters;
  Intent intent;
  Senses senses;
  ForcePacket force;
  int force_age{kForceLifetime}, sight_age{kSightLifetime};
  bool ready{false};
  bool started{false};
  Tick ready_ticks{0};
  std::uint32_t sequence{0};
};

Console::Console(const ConsoleConfig& config, std::unique_ptr<MotionSource> source)
    : impl_(std::make_unique<Impl>(config, std::move(source))) {}
Console::~Console() = default;

void Console::setReady(bool ready) noexcept {
  impl_->ready = ready;
}

Reject Console::applyForce(const ForcePacket& force) noexcept {
  const Reject reason = order(force.sequence, impl_->force.sequence);
  if (reason != Reject::kNone && impl_->force_age < kForceLifetime) return reason;
  if (!isPlausible(force)) return Reject::kOutOfRange;
  impl_->force = force;
  impl_->force_age = 0;
  if (force.runlevel == static_cast<std::uint8_t>(RunLevel::kPedalUp)) impl_->ready = true;
  return Reject::kNone;
}

Reject Console::applySight(const Sight& sight) noexcept {
  const std::optional<Sight>& last = impl_->senses.sight;
  const Reject reason = last ? order(sight.sequence, last->sequence) : Reject::kNone;
  if (reason != Reject::kNone && impl_->sight_age < kSightLifetime) return reason;
  if (!isPlausible(sight)) return Reject::kNotFinite;
  impl_->senses.sight = sight;
  impl_->sight_age = 0;
  return Reject::kNone;
}

std::uint32_t Console::pedals() const noexcept {
  return impl_->intent.pedals;
}

bool Console::finished() const noexcept {
  return impl_->intent.finished;
}

bool Console::isReal() const noexcept {
  return impl_->is_real;
}

PerArm<Vec3> Console::deflection() const noexcept {
  return {toArray(impl_->masters[0].hand.deflection()), toArray(impl_->masters[1].hand.deflection())};
}

wire::ItpPacket Console::tick() {
  wire::ItpPacket packet;
  packet.sequence = ++impl_->sequence;
  const bool may_move = impl_->mayMove();
  impl_->senses.may_move = may_move;
  if (may_move) {
    impl_->move(&packet);
  } else if (impl_->is_real) {
    impl_->intent.finished = impl_->source->tick(impl_->senses).finished;
  }
  impl_->force_age = std::min(impl_->force_age + 1, kForceLifetime);
  impl_->sight_age = std::min(impl_->sight_age + 1, kSightLifetime);
  packet.checksum = wire::itpChecksum(packet);
  return packet;
}

void Console::Impl::move(wire::ItpPacket* packet) {
  const bool is_first = !started;
  started = true;
  feel();
  intent = source->tick(senses);
  packet->surgeon_mode = intent.pedal ? 1 : 0;
  for (const Arm arm : kArms) {
    moveMaster(arm, intent.pedal && !is_first, packet);
    turnMaster(arm, intent.pedal && !is_first, packet);
  }
}

bool Console::Impl::mayMove() noexcept {
  if (started) return true;
  const bool is_over = ready && static_cast<double>(ready_ticks) * kTickSeconds >= config.start_delay;
  ready_ticks = ready ? ready_ticks + 1 : 0;
  return is_over;
}

void Console::Impl::feel() noexcept {
  senses.sequence = sequence;
  senses.force = force_age < kForceLifetime ? force : ForcePacket{};
  senses.force.runlevel = force.runlevel;
  for (const Arm arm : kArms)
    at(senses.deflection, arm) = toArray(at(masters, arm).hand.deflection());
}

Vector3 Console::Impl::forceOn(Arm arm) const noexcept {
  const bool acts = !is_real && intent.pedal && force_age < kForceLifetime;
  return acts ? toEigen(at(force.force_I, arm)) : Vector3(0.0, 0.0, 0.0);
}

void Console::Impl::moveMaster(Arm arm, bool counts, wire::ItpPacket* packet) noexcept {
  Master& master = at(masters, arm);
  master.hand.step(forceOn(arm));
  const Vector3 steps =
      kMicrometresPerMetre * config.scale * (toEigen(at(intent.hand_I, arm)) + master.hand.deflection());
  const double closing = -kMilliradiansPerRadian * at(intent.grasp, arm);  // ITP: positive closes
  if (!counts) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      master.position[axis].hold(steps[static_cast<Eigen::Index>(axis)]);
    master.grasp.hold(closing);
    return;
  }
  at(packet->delx_um, arm) = master.position[0].take(steps.x());
  at(packet->dely_um, arm) = master.position[1].take(steps.y());
  at(packet->delz_um, arm) = master.position[2].take(steps.z());
  at(packet->grasp_mrad, arm) = master.grasp.take(closing);
}

void Console::Impl::turnMaster(Arm arm, bool counts, wire::ItpPacket* packet) noexcept {
  TurnIncrement& turn = at(masters, arm).turn;
  if (!counts) return turn.hold(at(intent.turn_I, arm));
  const Quat step = turn.take(at(intent.turn_I, arm));
  at(packet->Qx, arm) = step[0];
  at(packet->Qy, arm) = step[1];
  at(packet->Qz, arm) = step[2];
  at(packet->Qw, arm) = step[3];
}

}  // namespace raven2_trainer::console
