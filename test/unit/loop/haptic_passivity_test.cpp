#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/haptics/hand_model.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "support/effort.h"

// Tests the haptic loop closed over a hand on a slow link: the energy that the port gives the hand, with and without
// the passivity controller. The work is summed at the hand, where the daemon cannot measure it.

namespace raven2_trainer::loop {
namespace {

/** Parameters of the hand, the link and the robot. */
struct Bench {
  double mass{0.15}, damping{2.0}, stiffness{300.0};  ///< [kg, Ns/m, N/m] a loose hand; doc/haptics.md
  int there{50}, back{50};                            ///< [ticks] daemon to console, console to daemon
  Vector3 offset_B{0.003, 0.0, 0.0};                  ///< [m] model from robot while the hand rests
  Vector3 kick_I{0.0, 0.0, -0.3};                     ///< [N] for 20 ms
  double seconds{20.0};
  Vector3 rest_I{0, 0, 0};  ///< [m] where the hand holds still
  double busy{0.0};         ///< [s] of strokes to the side before the kick, 30 mm to and fro in 2 s
};

/** Result of a run, for the gold arm. */
struct Outcome {
  double amplitude{};      ///< [m] half of the hand's travel in the last 2 s, along the axis with the most
  double energy{};         ///< [J] given to the hand since its release, measured at the hand
  double excess{-1.0};     ///< [J] largest excess of that energy over the promise; not positive if the promise holds
  double largest_force{};  ///< [N] in the last 2 s
  double least_gain{1.0};  ///< [-] of all ticks
};

TrainerConfig packaged() {
  return config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
}

/** A hand that holds still, a model that follows the hand and a robot that does not move, simulated tick by tick. */
class ClosedLoop {
 public:
  ClosedLoop(const TrainerConfig& configuration, const Bench& b)
      : config(handed(configuration, b)), bench(b), hand(config.console), loop(config, &shared) {}

  Outcome run() {
    const int ticks = static_cast<int>(bench.seconds / kTickSeconds);
    for (int k = 0; k < ticks; ++k)
      tick(k);
    Outcome out;
    const int last = std::max(0, ticks - 2000);
    for (int axis = 0; axis < 3; ++axis) {
      double low = 1e9, high = -1e9;
      for (int k = last; k < ticks; ++k) {
        low = std::min(low, positions[static_cast<std::size_t>(k)][axis]);
        high = std::max(high, positions[static_cast<std::size_t>(k)][axis]);
      }
      out.amplitude = std::max(out.amplitude, 0.5 * (high - low));
    }
    const int released = static_cast<int>(bench.busy / kTickSeconds);
    out.energy = work.back() - (released > 0 ? work[static_cast<std::size_t>(released - 1)] : 0.0);
    for (int k = last; k < ticks; ++k)
      out.largest_force = std::max(out.largest_force, forces[static_cast<std::size_t>(k)].norm());
    out.least_gain = least_gain;
    out.excess = excess();
    return out;
  }

 private:
  static TrainerConfig handed(TrainerConfig config, const Bench& bench) {
    config.console.hand_mass = bench.mass;
    config.console.hand_damping = bench.damping;
    config.console.hand_stiffness = bench.stiffness;
    return config;
  }

  void tick(int k) {
    moveHand(k);
    receiveMotion(k);
    stepLoop(k);
  }

  /** One millisecond of the console: the hand moves under the force that has arrived. */
  void moveHand(int k) {
    const int given = k - 1 - bench.there;  // sent in the tick before, at the earliest
    const Vector3 acting = given >= 0 ? sent[static_cast<std::size_t>(given)] : Vector3(0, 0, 0);
    const Vector3 before = hand.deflection();
    hand.step(acting + handsOwn(k));
    positions.push_back(hand.deflection());
    forces.push_back(acting);
    work.push_back((work.empty() ? 0.0 : work.back()) + acting.dot(hand.deflection() - before));
  }

  /** Forces on the hand in addition to the port's: strokes, rest position and kick. */
  Vector3 handsOwn(int k) const {
    const int since = k - static_cast<int>(bench.busy / kTickSeconds);
    if (since < 0) return {0.0, 0.03 * bench.stiffness * std::sin(kPi * k * kTickSeconds), 0.0};
    return bench.stiffness * bench.rest_I + (since < 20 ? bench.kick_I : Vector3(0, 0, 0));
  }

  /** Sums the increments that have arrived, in whole micrometres of the tip. */
  void receiveMotion(int k) {
    const Vector3 seen = k >= bench.back ? positions[static_cast<std::size_t>(k - bench.back)] : Vector3(0, 0, 0);
    master_I = 1e-6 * (1e6 * config.console.scale * seen).array().round().matrix();
  }

  void stepLoop(int k) {
    const std::int64_t now_ns = (k + 1) * kTickNanoseconds;
    const Vector3 p_B = bench.offset_B + control::itpToBase(Arm::kGold) * master_I;
    ModelState model;
    model.tick = k + 1;
    model.time_ns = now_ns;
    model.linked = model.pedal = 1;
    model.master_I[0] = toArray(master_I);
    model.arms[0].p_BT = toArray(p_B);
    model.arms[0].v_BT = toArray(Vector3((p_B - p_before_B) / kTickSeconds));
    p_before_B = p_B;
    RobotState robot;
    robot.frame = robot.cycle = static_cast<std::uint64_t>(k + 1);
    robot.connected = 1;
    robot.received_ns = now_ns;
    shared.model.store(model);
    shared.robot.store(robot);
    loop.tick(now_ns);
    ForcePacket packet;
    while (shared.force_packets.tryPop(&packet)) {
    }
    HapticRecord record;
    while (shared.haptic_records.tryPop(&record)) {
    }
    sent.push_back(toEigen(packet.force_I[0]));
    asked.push_back(record.haptic.cue_B[0] != Vec3{} || record.haptic.edge_B[0] != Vec3{});
    least_gain = std::min(least_gain, record.haptic.gain[0]);
  }

  /** One account of the guard: the ticks of the hand in which it holds, and where the daemon saw the hand at its start.
   *  The budget is the energy that the hand may get from `begin` on beyond what its damping takes. */
  struct Account {
    std::size_t begin, end;
    Vector3 anchor;
    double budget;  ///< [J]
  };

  /** An account begins with the first wanted force after a rest. At the hand it acts `there` and one tick later. */
  std::vector<Account> accounts() const {
    const PassivityConfig& guard = config.haptics.passivity;
    const auto rest = static_cast<int>(std::lround((guard.max_delay + guard.rest) / kTickSeconds)) + 1;
    std::vector<Account> all;
    int silence = rest;
    for (std::size_t j = 0; j < sent.size(); ++j) {
      const bool acts = asked[j] || sent[j] != Vector3(0, 0, 0);
      if (acts && silence >= rest) {
        const std::size_t begin = std::min(positions.size(), j + 1 + static_cast<std::size_t>(bench.there));
        const auto back = static_cast<std::size_t>(bench.back);
        if (!all.empty()) all.back().end = begin;
        const Vector3 anchor = j >= back ? positions[j - back] : Vector3(0, 0, 0);
        all.push_back({begin, positions.size(), anchor, guard.budget});
      }
      silence = acts ? 0 : silence + 1;
    }
    return all;
  }

  double excess() const {
    double worst = -1.0;
    for (const Account& account : accounts()) {
      worst = std::max(worst, excess(account));
      const auto released = static_cast<std::size_t>(bench.busy / kTickSeconds);
      if (released > account.begin && released < account.end) worst = std::max(worst, excess(since(released, account)));
    }
    return worst;
  }

  /** The same account from a later tick on. Its budget is the bank plus the energy that the acting force has stored. */
  Account since(std::size_t tick, const Account& account) const {
    const double stored = std::max(0.0, forces[tick].dot(account.anchor - positions[tick]));
    return {tick, account.end, account.anchor, config.haptics.passivity.bank + stored};
  }

  /**
   * [J] largest excess of the hand's energy over the promise (doc/haptics.md). The promise holds for a tick if an
   * earlier tick meets both conditions:
   *
   * - From then on the hand got no more energy than the forces then under way and the floor give.
   * - By then it had no more than budget + the least damping's share + the energy that the force then acting takes back
   *   if the hand returns to where the account began.
   *
   * The forces under way are those of a round trip, their fall at the slew, and one tick. With an edge there are two
   * accounts and one more bank.
   */
  double excess(const Account& account) const {
    const int fall = static_cast<int>(std::ceil(config.haptics.max_force / config.haptics.max_slew / kTickSeconds));
    const auto under_way = static_cast<std::size_t>(bench.there + bench.back + fall + 1);
    double taken = 0.0, floor = 0.0, given = 0.0, worst = -1.0;
    std::deque<double> open;  // promises of the last ticks, minus the energy given by then
    const double budget = account.budget + (config.haptics.edge.enabled ? config.haptics.passivity.bank : 0.0);
    double ended = budget, before = account.begin > 0 ? work[account.begin - 1] : 0.0;
    const double start = before;
    for (std::size_t k = account.begin; k < account.end; ++k) {
      const Vector3 step = k > 0 ? Vector3(positions[k] - positions[k - 1]) : Vector3(0, 0, 0);
      taken += config.haptics.passivity.hand_damping * step.squaredNorm() / kTickSeconds;
      floor += config.haptics.min_force * step.norm();
      given += std::abs(work[k] - before);
      before = work[k];
      const double back = std::max(0.0, forces[k].dot(positions[k] - account.anchor));
      open.push_back(budget + taken + back - given);
      if (open.size() > under_way) {
        ended = std::max(ended, open.front() + given);
        open.pop_front();
      }
      const double promised = std::max(ended, *std::max_element(open.begin(), open.end()) + given);
      worst = std::max(worst, work[k] - start - promised - floor);
    }
    return worst;
  }

  const TrainerConfig config;
  const Bench bench;
  haptics::HandModel hand;
  SharedState shared;
  HapticLoop loop;
  Vector3 master_I{0, 0, 0}, p_before_B{bench.offset_B};
  double least_gain{1.0};

  std::vector<Vector3> sent;       ///< [N] [@frame I] by the daemon
  std::vector<bool> asked;         ///< whether the law wanted a force
  std::vector<Vector3> positions;  ///< [m] of the hand
  std::vector<Vector3> forces;     ///< [N] on the hand
  std::vector<double> work;        ///< [J] on the hand so far
};

Outcome outcome(TrainerConfig config, const Bench& bench, bool guarded) {
  config.haptics.passivity.enabled = guarded;
  return std::make_unique<ClosedLoop>(config, bench)->run();
}

void print(const char* what, const Outcome& o) {
  std::printf("%-34s amplitude %7.3f mm, energy %9.2f mJ, force %.3f N, least gain %.3f\n", what, 1e3 * o.amplitude,
              1e3 * o.energy, o.largest_force, o.least_gain);
}

TEST(HapticPassivity, ALooseHandBehindFiftyMillisecondsEachWayIsLeftInPeace) {
  // GIVEN the packaged gains, a deviation of just the 3 mm at which the force begins, and a robot that does not move
  const TrainerConfig config = packaged();
  const Bench bench;
  const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
  print("plain law", plain);
  print("with the passivity controller", guarded);
  // THEN the paper's law keeps the hand swinging for ever
  EXPECT_GT(plain.amplitude, 0.003);
  EXPECT_GT(plain.energy, 0.4);
  EXPECT_EQ(plain.least_gain, 1.0);
  // and with the controller only the floor of 0.05 N moves the hand: by 4/pi 0.05 N / (b w) = 0.7 mm at most
  EXPECT_LT(guarded.amplitude, 0.0007);
  EXPECT_LT(guarded.energy, 0.1 * plain.energy);
  EXPECT_LE(guarded.largest_force, config.haptics.min_force + 1e-12);
  EXPECT_LE(guarded.excess, 0.0);
}

TEST(HapticPassivity, AMinuteOfWorkBeforeDoesNotBuyALooseHandASwing) {
  // GIVEN a minute of strokes under a constant force, in which the hand's damping takes 0.26 J. Then the hand is
  // released and knocked.
  TrainerConfig config = packaged();
  Bench bench;
  bench.busy = 60.0;
  bench.seconds = 80.0;
  bench.kick_I = {0.0, 0.0, -1.5};  // knocks the hand out of the cue, which by then deflects it by 1.6 mm
  const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
  print("after a minute, plain", plain);
  print("after a minute, guarded", guarded);
  EXPECT_GT(plain.amplitude, 0.003);
  EXPECT_GT(plain.energy, 0.4);
  // THEN the hand gets no more energy than the bank and what its damping takes
  EXPECT_LT(guarded.amplitude, 0.0007);
  EXPECT_LT(guarded.energy, 0.15 * plain.energy);
  EXPECT_LE(guarded.excess, 0.0);
  // and without a limit of the bank the hand would keep swinging
  config.haptics.passivity.bank = 1e9;
  const Outcome boundless = outcome(config, bench, true);
  print("the same without a limit", boundless);
  EXPECT_GT(boundless.energy, 4.0 * guarded.energy);
}

TEST(HapticPassivity, AMinuteOfStrokesUnderTheCueIsFeltWhole) {
  // GIVEN the console's own hand and the loose one, a cue of 10 mm, and strokes of 30 mm for a minute
  const TrainerConfig config = packaged();
  for (const bool is_loose : {false, true}) {
    Bench bench;
    bench.damping = is_loose ? bench.damping : config.console.hand_damping;
    bench.offset_B = {0.010, 0.0, 0.0};
    bench.busy = bench.seconds = 60.0;
    bench.kick_I = {0.0, 0.0, 0.0};
    const Outcome guarded = outcome(config, bench, true);
    print(is_loose ? "strokes of a loose hand" : "strokes of a plain hand", guarded);
    EXPECT_EQ(guarded.least_gain, 1.0);
    EXPECT_GT(guarded.largest_force, 1.5);
  }
}

TEST(HapticPassivity, AnObserverThatReckonsWithNoDelaySeesNothing) {
  // GIVEN an observer that sums force given times motion received, as for a device in the same computer
  TrainerConfig config = packaged();
  config.haptics.passivity.max_delay = 0.0;
  const Outcome out = outcome(config, Bench{}, true);
  print("an observer of no delay", out);
  EXPECT_GT(out.amplitude, 0.003);
  EXPECT_EQ(out.least_gain, 1.0);
}

TEST(HapticPassivity, StrongGainsAtFullScaleNoLongerSwingTheHandByCentimetres) {
  TrainerConfig config = packaged();
  config.haptics.kp = 300.0;
  config.console.scale = 1.0;
  const Bench bench;
  const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
  print("300 N/m, scale 1, plain", plain);
  print("300 N/m, scale 1, guarded", guarded);
  EXPECT_GT(plain.amplitude, 0.02);
  EXPECT_DOUBLE_EQ(plain.largest_force, config.haptics.max_force);
  EXPECT_LT(guarded.amplitude, 0.0007);
  EXPECT_LT(guarded.energy, 0.02 * plain.energy);
  EXPECT_LE(guarded.excess, 0.0);
}

TEST(HapticPassivity, WithoutAFloorTheHandComesToRest) {
  TrainerConfig config = packaged();
  config.haptics.min_force = 0.0;
  const Outcome guarded = outcome(config, Bench{}, true);
  print("no floor, guarded", guarded);
  EXPECT_LT(guarded.amplitude, 0.0002);
}

TEST(HapticPassivity, APlainHandFeelsTheWholeCue) {
  // GIVEN the console's own hand, near critical damping, and a robot 10 mm away: no swing, nothing taken
  const TrainerConfig config = packaged();
  Bench bench;
  bench.mass = config.console.hand_mass;
  bench.damping = config.console.hand_damping;
  bench.stiffness = config.console.hand_stiffness;
  bench.offset_B = {0.010, 0.0, 0.0};
  bench.seconds = 5.0;
  const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
  print("a plain hand", guarded);
  EXPECT_EQ(guarded.least_gain, 1.0);
  EXPECT_EQ(guarded.largest_force, plain.largest_force);
  EXPECT_GT(guarded.largest_force, 1.5);
  EXPECT_LT(plain.amplitude, 1e-4);
}

TEST(HapticPassivity, AnEdgeThatSwingsTheHandYieldsAndTheCueStays) {
  // GIVEN a hand that rests 5 mm inside the edge's margin, where its spring of 225 N/m is steepest, and a cue of 10 mm
  TrainerConfig config = packaged();
  config.haptics.edge.enabled = true;
  config.haptics.edge.origin = WorkspaceOrigin::kStart;
  config.haptics.edge.size_I = {0.5, 0.03, 0.5};  // 5 mm free to either side, then the margin
  Bench bench;
  bench.offset_B = {0.010, 0.0, 0.0};
  bench.kick_I = {0.0, 3.0, 0.0};
  bench.rest_I = {0.0, 0.010, 0.0};
  const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
  print("an edge behind 50 ms each way", plain);
  print("the same, guarded", guarded);
  EXPECT_GT(plain.amplitude, 0.0015) << "the delay makes the edge swing the hand";
  EXPECT_LT(guarded.amplitude, 0.1 * plain.amplitude);
  EXPECT_EQ(guarded.least_gain, 1.0) << "the cue does not swing the hand and keeps its gain";
  EXPECT_GT(guarded.largest_force, 1.4) << "the cue is felt";
  EXPECT_LE(guarded.excess, 0.0);
}

/** Draws links with delays up to the bound, hands with damping down to the least, and gains up to those that push such
 *  a hand away. In most draws the hand's own swing comes back from the link as a push. */
Bench anyBench(Random* random, TrainerConfig* config) {
  Bench bench;
  bench.there = static_cast<int>(random->next() % 61);
  bench.back = static_cast<int>(random->next() % 60);
  bench.damping = random->uniform(config->haptics.passivity.hand_damping, 2.0);
  bench.stiffness = random->uniform(100.0, 500.0);
  const double round_trip = kTickSeconds * std::max(30, bench.there + bench.back);
  const double omega = random->uniform(0.9, 2.1) * kPi / round_trip;  // the link pushes for factors between 1 and 2
  bench.mass = std::clamp(bench.stiffness / (omega * omega), 0.04, 1.0);
  config->console.scale = random->uniform(0.05, 1.0);
  config->haptics.kp = std::min(2000.0, random->uniform(0.2, 1.1) * bench.stiffness / config->console.scale);
  config->haptics.kd = random->uniform(0.0, 5.0);
  config->haptics.min_force = random->next() % 2 == 0 ? 0.0 : 0.05;
  const Vector3 direction(random->uniform(-1.0, 1.0), random->uniform(-1.0, 1.0), random->uniform(-1.0, 1.0));
  bench.offset_B = random->uniform(0.0025, 0.004) * direction.normalized();
  bench.kick_I = {random->uniform(-2.0, 2.0), random->uniform(-2.0, 2.0), random->uniform(-2.0, 2.0)};
  bench.seconds = 8.0;
  return bench;
}

TEST(HapticPassivity, TheHandIsNeverGivenMoreThanWasPromised) {
  Random random(11);
  const TrainerConfig base = packaged();
  const auto wanted = static_cast<int>(raven2_trainer::testing::effort(24, 60));
  int broken = 0, stilled = 0, runs = 0;
  for (; runs < wanted; ++runs) {
    TrainerConfig config = base;
    const Bench bench = anyBench(&random, &config);
    const Outcome plain = outcome(config, bench, false), guarded = outcome(config, bench, true);
    EXPECT_LE(guarded.excess, 1e-4) << "run " << runs;  // a micrometre of the tip is up to 20 of the hand
    const bool breaks = plain.excess > 1e-3;
    broken += breaks ? 1 : 0;
    stilled += breaks && guarded.amplitude < 0.1 * plain.amplitude ? 1 : 0;
  }
  std::printf("of %d loops %d break the promise without the controller; with it %d of those swing less than a tenth\n",
              runs, broken, stilled);
  EXPECT_GT(4 * broken, runs) << "the plain law keeps the promise too often: the test checks little";
  EXPECT_EQ(stilled, broken);
}

}  // namespace
}  // namespace raven2_trainer::loop
