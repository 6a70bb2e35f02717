#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "python/arena.h"
#include "python/constructed.h"
#include "python/under_way.h"
#include "raven2_trainer/config/overrides.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/commanded_source.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/render/picture_line.h"

namespace raven2_trainer::python {

/** Where a simulation begins. */
struct SimulationOptions {
  std::string exercise{"none"};
  std::string hazard{"none"};
  std::string motion{"commands"};  ///< or a simulated surgeon: MotionChoice::motion
  std::string config;              ///< root file; empty: the packaged one
  std::string output;              ///< session directory; empty: nothing is recorded
  std::uint64_t seed{1};
  bool has_robot{true};
  std::string plant;           ///< of the virtual Raven: preset of config/plants; empty: the configuration's
  std::string link{"none"};    ///< between hands and trainer: preset of config/impairments
  config::Overrides settings;  ///< values in place of the configuration's
};

/** The configuration that they stand for. @throw ConfigException. */
TrainerConfig loadConfig(const SimulationOptions& options);

/** Hazards of the robot or of the stream to it would be armed and change nothing. @throw std::invalid_argument. */
void demandRobotFor(const TrainerConfig& config, const std::string& hazard, bool has_robot);

/** Command to one arm. */
struct ArmCommand {
  Vec3 move_W{};                     ///< [m] motion of the tool in all ticks together
  Vec3 turn_W{};                     ///< [rad] its rotation vector, the same
  std::optional<JointArray> joints;  ///< [rad; m] set point at the end of the ticks, instead of the two above
  std::optional<double> jaw;         ///< [rad] opening; none: as before. Not with `joints`, which have the jaws in them
};

struct StepCommand {
  PerArm<ArmCommand> arms{};
  bool pedal{true};
  bool is_none{false};  ///< the tools rest
};

/** Requests about hazards that the next tick serves. */
struct AskedHazards {
  std::size_t rows{0};      ///< of those to begin
  bool all_cleared{false};  ///< before that
};

/** A copy of all of a simulation's state. It fits that simulation alone. */
struct Snapshot : Constructed {
  std::uint64_t owner{};
  PerArm<std::optional<double>> jaws{};
  UnderWay under_way;
  AskedHazards asked;
  std::vector<std::byte> memory;
};

/**
 * Console, daemon and virtual Raven in lockstep for a program: LockstepStack with commands from outside. All its state
 * is in one arena. Calls may come from any thread; they wait for each other. After close() all of them throw
 * std::runtime_error.
 */
class Simulation : public Constructed {
 public:
  /** @throw ConfigException, ModelException, SessionException. */
  explicit Simulation(const SimulationOptions& options);
  ~Simulation();

  /** @throw std::invalid_argument for a motion that is too fast, and where a simulated surgeon has the hands. */
  void check(const StepCommand& command, int ticks) const;

  /** Ticks of a command. @param[in] interrupt is called once a second of them: it may use the simulation, close it too,
   *  and throw. @throw as check(). */
  void step(
      const StepCommand& command,
      int ticks,
      const std::function<void()>& interrupt = [] {});

  /** Pedal up, until the arms wait for it. @return ticks. @throw std::runtime_error after `limit` ticks. */
  int start(
      int limit,
      const std::function<void()>& interrupt = [] {});

  Snapshot save();
  /** @throw std::invalid_argument for another simulation's. */
  void restore(const Snapshot& snapshot);

  /** From now on the link, injected hazards and drills of later attempts draw from this seed. Packets in flight of a
   * bad link are lost.
   *  @throw std::runtime_error if the simulation is recorded: its log has one seed. */
  void reseed(std::uint64_t seed);

  /** A scenario of the library, at once. @throw ConfigException; std::runtime_error if too many are armed already. */
  void inject(const std::string& hazard);
  void clearHazards();

  /** Writes the end of the recorded session. Views stay readable until destruction. */
  void close();
  bool isClosed() const noexcept { return is_closed_; }

  const lockstep::LockstepView& view() const noexcept { return stack_->view(); }
  /** Gives the newest states to the surgeon's picture. The caller has mutex().
   *  @return the states that it shows, after faults of the video. */
  render::Snapshot passPicture();
  const TrainerConfig& config() const noexcept { return config_; }
  const model::SceneModel& scene() const noexcept { return *scene_; }
  const model::RavenModel& raven() const noexcept { return *raven_; }
  /** Of the newest tick. */
  ContactList contacts() const;
  std::vector<std::string> bodyNames() const;
  /** [rad; m] true joints of the robot's plant. */
  PerArm<JointArray> trueJoints() const;
  std::uint64_t number() const noexcept { return number_; }
  std::recursive_mutex& mutex() const noexcept { return mutex_; }
  /** [bytes] of a snapshot. */
  std::size_t stateSize() const noexcept { return arena_.used(); }

 private:
  class Recording;

  void demandOpen() const;
  void demand(const StepCommand& command, int ticks) const;
  void ask(const FaultRequest& request);
  void demandHands(const StepCommand& command) const;
  double largestMove() const;
  void demandSlow(Arm arm, const ArmCommand& command, int ticks) const;
  void build(const SimulationOptions& options);
  void destroyStack();
  void tick();
  console::HandsCommand handsFor(const StepCommand& command, int ticks, int left);
  double graspFor(Arm arm, bool pedal) const;
  void approach(Arm arm, const JointArray& joints, int left, console::HandsCommand* hands) const;
  Pose led(Arm arm) const;

  mutable std::recursive_mutex mutex_;  // interrupt() may come back to this simulation
  const std::uint64_t number_;
  TrainerConfig config_;
  const Impairment link_;
  std::shared_ptr<const model::RavenModel> raven_;
  std::shared_ptr<const model::SceneModel> scene_;
  std::unique_ptr<RecordRings> records_;
  Arena arena_;
  std::unique_ptr<Recording> recording_;
  console::CommandedSource* source_{nullptr};  // owned by the stack; null: a simulated surgeon
  std::unique_ptr<lockstep::LockstepStack> stack_;
  std::unique_ptr<render::PictureLine> pictures_;
  PerArm<std::optional<double>> jaws_{};  // [rad] commanded openings
  UnderWay under_way_;
  AskedHazards asked_;
  std::string end_trouble_;  // why the end of the recorded session was not written
  const pid_t process_;
  const bool has_robot_;
  bool is_closed_{false};
};

}  // namespace raven2_trainer::python
