#include "raven2_trainer/console/device_surgeon.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::console {
namespace {

constexpr int kLongestSpread = 20;   ///< [ticks] slower drivers than 50 Hz are felt as steps, rather than late
constexpr double kUsual = 0.125;     ///< [-] weight of the newest interval between poses in the usual one
constexpr double kMaxStep = 0.0019;  ///< [m] of the tool in one packet: less than network.yaml's max_increment_um
constexpr Tick kConnecting = 2000;   ///< [ticks] a start in which silence is no news: ROS needs a moment

bool isSet(std::uint32_t buttons, int button) noexcept {
  return button >= 0 && button < 32 && ((buttons >> static_cast<unsigned>(button)) & 1U) != 0;
}

bool isHeld(const DeviceSample& sample, int button) noexcept {
  return isSet(sample.buttons, button);
}

double axisOf(const DeviceSample& sample, int number) noexcept {
  const bool is_there = number >= 0 && static_cast<std::uint32_t>(number) < sample.axis_count;
  return is_there ? sample.axes[static_cast<std::size_t>(number)] : 0.0;
}

/** One device: where the hand on it is, and how far its jaws are to open. */
class DeviceHand {
 public:
  DeviceHand(const MasterConfig& config, const DeviceTopics& topics, double jaws)
      : config_(config),
        topics_(topics),
        axes_(axisMatrix(config.axes)),
        turn_axes_(axisMatrix(config.turn_axes)),
        max_step_(kMaxStep / config.scale),
        jaws_(jaws),
        toggled_(jaws) {}

  /** Every tick, before follow(). Motion before the pedal was down must not count, even if a late pose reports it
   * afterwards: the first pose from there on is where the hand is. */
  void setEngaged(bool engaged) noexcept {
    if (engaged && !engaged_) {
      starts_ = true;
      ticks_left_ = 1;
      target_ = hand_;
      target_turn_ = turn_;
    }
    engaged_ = engaged;
  }

  void follow(const DeviceSample& sample) noexcept {
    if (traitsOf(config_.family).has_axes) {
      hand_ += axes_ * velocity(sample) * kTickSeconds;
    } else {
      followPoses(sample);
    }
    if (engaged_) moveJaws(sample);
    was_held_ = isHeld(sample, topics_.gripper_input);
  }

  const Vector3& hand() const noexcept { return hand_; }
  const Quat& turn() const noexcept { return turn_; }
  double jaws() const noexcept { return jaws_; }

 private:
  /** The hand moves to a pose within the time since the one before, or the usual time if it came early. So a driver of
   * 100 Hz
   * makes no steps of 10 ms, and neither do two of its poses that come together on a busy computer. */
  void followPoses(const DeviceSample& sample) noexcept {
    ++since_pose_;
    if (sample.poses != poses_) {
      aimAt(sample);
      const int interval = std::clamp(since_pose_, 1, kLongestSpread);
      usual_ = usual_ > 0.0 ? usual_ + kUsual * (interval - usual_) : interval;
      ticks_left_ = std::max(interval, static_cast<int>(std::lround(usual_)));
      since_pose_ = 0;
    }
    const double share = 1.0 / ticks_left_;
    Vector3 step = share * (target_ - hand_);
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > max_step_) step *= max_step_ / largest;
    hand_ += step;
    turn_ = ticks_left_ == 1 ? target_turn_ : toArray(toEigen(turn_).slerp(share, toEigen(target_turn_)));
    ticks_left_ = std::max(ticks_left_ - 1, 1);
  }

  void aimAt(const DeviceSample& sample) noexcept {
    const Quaternion q_now = config_.orientation ? toEigen(sample.orientation).normalized() : Quaternion::Identity();
    const Vector3 p = config_.metres_per_unit * toEigen(sample.position);
    poses_ = sample.poses;
    if (starts_) return startAt(p, q_now);
    target_ = axes_ * (p - start_);
    Quaternion turn = q_now * q_start_.conjugate();
    turn.vec() = (turn_axes_ * turn.vec()).eval();
    target_turn_ = toArray(turn);
  }

  /** The hand stays where it is, and that is there. */
  void startAt(const Vector3& p, const Quaternion& q_now) noexcept {
    starts_ = false;
    start_ = p - axes_.transpose() * hand_;
    Quaternion turned = toEigen(turn_);
    turned.vec() = (turn_axes_.transpose() * turned.vec()).eval();
    q_start_ = turned.conjugate() * q_now;
  }

  Vector3 velocity(const DeviceSample& sample) const noexcept {
    Vector3 v;
    for (std::size_t k = 0; k < 3; ++k)
      v[static_cast<Eigen::Index>(k)] = config_.stick_speed * pushed(axisOf(sample, topics_.sticks[k]));
    return v;
  }

  /** Share of the distance from the edge of the dead band to the stick's end. */
  double pushed(double stick) const noexcept {
    const double beyond = std::min(std::abs(stick), 1.0) - config_.dead_band;
    return beyond <= 0.0 ? 0.0 : std::copysign(beyond / (1.0 - config_.dead_band), stick);
  }

  void moveJaws(const DeviceSample& sample) noexcept {
    const double step = config_.jaw_speed * kTickSeconds;
    jaws_ += std::clamp(wantedJaws(sample) - jaws_, -step, step);
  }

  double wantedJaws(const DeviceSample& sample) noexcept {
    const bool held = isHeld(sample, topics_.gripper_input);
    switch (config_.gripper_from) {
      case GripperFrom::kHolds:
        return held ? config_.jaws_closed : config_.jaws_open;
      case GripperFrom::kToggles:
        if (held && !was_held_) toggled_ = isNearerOpen(toggled_) ? config_.jaws_closed : config_.jaws_open;
        return toggled_;
      case GripperFrom::kJoint:
        return sample.has_gripper != 0 ? fromReading(sample.gripper) : jaws_;
      case GripperFrom::kAxis:
        return fromReading(axisOf(sample, topics_.gripper_input));
      case GripperFrom::kNone:
        break;
    }
    return jaws_;
  }

  bool isNearerOpen(double jaws) const noexcept {
    return std::abs(jaws - config_.jaws_open) <= std::abs(jaws - config_.jaws_closed);
  }

  double fromReading(double reading) const noexcept {
    if (!std::isfinite(reading)) return jaws_;
    const double share = (reading - config_.reading_closed) / (config_.reading_open - config_.reading_closed);
    return config_.jaws_closed + std::clamp(share, 0.0, 1.0) * (config_.jaws_open - config_.jaws_closed);
  }

  const MasterConfig& config_;
  const DeviceTopics& topics_;
  const Eigen::Matrix3d axes_, turn_axes_;
  const double max_step_;  ///< [m] of the hand in a tick, along each axis; what is beyond follows
  std::uint32_t poses_{0};
  int since_pose_{0}, ticks_left_{1};
  double usual_{0.0};                   ///< [ticks] between poses; 0 before the first
  bool engaged_{false}, starts_{true};  ///< the next pose moves nothing
  Vector3 start_{0, 0, 0};              ///< [m] where hand_ would be zero, the device's axes
  Quaternion q_start_{Quaternion::Identity()};
  Vector3 target_{0, 0, 0};  ///< [m] [@frame I] from there: the newest pose
  Quat target_turn_{kIdentityQuat};
  Vector3 hand_{0, 0, 0};  ///< [m] [@frame I] on the way to it
  Quat turn_{kIdentityQuat};
  double jaws_, toggled_;  ///< [rad]
  bool was_held_{false};
};

class DeviceSurgeon : public MotionSource {
 public:
  DeviceSurgeon(const MasterConfig& config, const PerArm<double>& jaws, MasterLink* link)
      : config_(config),
        link_(*link),
        hands_{DeviceHand(config_, config_.devices[0], jaws[0]), DeviceHand(config_, config_.devices[1], jaws[1])},
        watches_{DeviceWatch(config_), DeviceWatch(config_)} {}

  bool isReal() const noexcept override { return true; }

  Intent tick(const Senses& senses) override {
    ++now_;
    hear();
    inspect();
    engage(senses.may_move);
    Intent intent;
    intent.pedal = engaged_;
    for (const Arm arm : kArms) {
      move(arm, &intent);
      press(arm, at(senses.force.force_I, arm));
    }
    report_.engaged = engaged_ ? 1 : 0;
    link_.report.store(report_);
    return intent;
  }

 private:
  bool isUsed(Arm arm) const noexcept { return at(config_.devices, arm).is_used; }

  void hear() noexcept {
    for (const Arm arm : kArms)
      at(link_.samples, arm).tryLoad(&at(samples_, arm));
    link_.pedal.tryLoad(&foot_);
    report_.pedal = isPedalHeld() ? 1 : 0;
  }

  bool isPedalHeld() const noexcept {
    const bool left = isUsed(Arm::kGold) && isSet(samples_[0].buttons & ~stale_[0], config_.pedal_button);
    const bool right = isUsed(Arm::kGreen) && isSet(samples_[1].buttons & ~stale_[1], config_.pedal_button);
    switch (config_.pedal_from) {
      case PedalFrom::kLeft:
        return left;
      case PedalFrom::kRight:
        return right;
      case PedalFrom::kAny:
        return left || right;
      case PedalFrom::kAll:
        return (left || !isUsed(Arm::kGold)) && (right || !isUsed(Arm::kGreen)) && (left || right);
      case PedalFrom::kTopic:
        break;
    }
    return foot_.is_held != 0;
  }

  void inspect() noexcept {
    for (const Arm arm : kArms) {
      if (!isUsed(arm)) continue;
      const DeviceFinding before = at(report_.now, arm);
      const DeviceFinding found = at(watches_, arm).look(at(samples_, arm), engaged_);
      at(report_.now, arm) = found;
      const bool is_unheard = found.trouble == DeviceTrouble::kNeverHeard || found.trouble == DeviceTrouble::kNoState;
      const bool is_connecting = is_unheard && now_ < kConnecting;
      const bool is_late_news = is_unheard && now_ == kConnecting;
      if ((found.trouble != before.trouble && !is_connecting) || is_late_news) note(arm, found);
      noteLock(arm);
      distrustButtons(arm);
    }
  }

  /** A driver that died with its button down says nothing of its release: the pedal is pressed again, or up. */
  void distrustButtons(Arm arm) noexcept {
    const std::uint32_t held = at(samples_, arm).buttons;
    at(stale_, arm) = at(report_.now, arm).trouble == DeviceTrouble::kSilent ? held : at(stale_, arm) & held;
  }

  /** Reported, but no reason to stop: not all drivers that report it hold the device. */
  void noteLock(Arm arm) noexcept {
    const bool is_locked = at(samples_, arm).is_locked != 0;
    if (is_locked && !at(locked_, arm)) note(arm, {DeviceTrouble::kLocked, 0.0});
    at(locked_, arm) = is_locked;
  }

  void note(Arm arm, const DeviceFinding& finding) noexcept {
    if (finding.trouble == DeviceTrouble::kNone) return;
    ++at(report_.found, arm);
    at(report_.newest, arm) = finding;
  }

  /** A pedal that met something wrong has to go up before it counts again. */
  void engage(bool may_move) noexcept {
    const bool held = report_.pedal != 0;
    if (!held) {
      engaged_ = refused_ = false;
    } else if (engaged_ && isWrong()) {
      engaged_ = false;
      refused_ = true;
    } else if (!engaged_ && !refused_) {
      engaged_ = isGoodToStart(may_move);
      refused_ = !engaged_;
      report_.engagements += engaged_ ? 1U : 0U;
    }
  }

  bool isWrong() const noexcept {
    return std::any_of(report_.now.begin(), report_.now.end(),
                       [](const DeviceFinding& found) { return liftsPedal(found.trouble); });
  }

  bool isGoodToStart(bool may_move) noexcept {
    bool is_good = may_move;
    for (const Arm arm : kArms) {
      if (!isUsed(arm)) continue;
      DeviceFinding found = at(report_.now, arm);
      if (found.trouble == DeviceTrouble::kNone) found = at(watches_, arm).beforeStart();
      if (found.trouble == DeviceTrouble::kNone && !may_move) found.trouble = DeviceTrouble::kRobotNotReady;
      note(arm, found);
      is_good = is_good && found.trouble == DeviceTrouble::kNone;
    }
    return is_good;
  }

  void move(Arm arm, Intent* intent) noexcept {
    DeviceHand& hand = at(hands_, arm);
    hand.setEngaged(engaged_);
    if (isUsed(arm) && !liftsPedal(at(report_.now, arm).trouble)) hand.follow(at(samples_, arm));
    at(intent->hand_I, arm) = toArray(hand.hand());
    at(intent->turn_I, arm) = hand.turn();
    at(intent->grasp, arm) = hand.jaws();
  }

  void press(Arm arm, const Vec3& force_I) noexcept {
    DeviceForce& out = at(forces_, arm);
    place(at(samples_, arm), &out);
    if (engaged_) out.has_begun = 1;
    out.force = engaged_ ? toDevice(config_, force_I) : Vec3{};
    at(report_.hand_force, arm) = toEigen(out.force).norm() / config_.force_per_newton;
    at(link_.forces, arm).store(out);
  }

  /** A driver that holds a device at a place pulls it there. */
  static void place(const DeviceSample& sample, DeviceForce* out) noexcept {
    if (sample.poses == 0 || !toEigen(sample.position).allFinite()) return;
    out->position = sample.position;
    out->is_placed = 1;
  }

  const MasterConfig config_;
  MasterLink& link_;
  PerArm<DeviceHand> hands_;
  PerArm<DeviceWatch> watches_;
  PerArm<DeviceSample> samples_;
  FootPedal foot_;
  MasterReport report_;
  Tick now_{0};
  bool engaged_{false}, refused_{false};
  PerArm<DeviceForce> forces_;
  PerArm<bool> locked_{};
  PerArm<std::uint32_t> stale_{};  ///< buttons held since a silence
};

}  // namespace

Eigen::Matrix3d axisMatrix(const AxisMap& map) noexcept {
  Eigen::Matrix3d matrix;
  for (std::size_t row = 0; row < 3; ++row)
    matrix.row(static_cast<Eigen::Index>(row)) = toEigen(map[row]).transpose();
  return matrix;
}

Vec3 toDevice(const MasterConfig& config, const Vec3& force_I) noexcept {
  Vector3 force = axisMatrix(config.axes).transpose() * toEigen(force_I);
  const double size = force.norm();
  if (!std::isfinite(size)) return {};
  if (size > config.max_force) force *= config.max_force / size;
  return toArray(Vector3(config.force_per_newton * force));
}

std::unique_ptr<MotionSource> makeDeviceSurgeon(const MasterConfig& config,
                                                const PerArm<double>& jaws,
                                                MasterLink* link) {
  return std::make_unique<DeviceSurgeon>(config, jaws, link);
}

}  // namespace raven2_trainer::console
