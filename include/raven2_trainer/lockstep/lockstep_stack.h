#pragma once

#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/raven/raven_report.h"

namespace raven2_trainer::lockstep {

/** Optional parts of a stack. */
struct StackParts {
  std::shared_ptr<const model::RavenModel> raven;  ///< null: loaded for this stack alone
  std::shared_ptr<const model::SceneModel> scene;  ///< the same
  RecordRings* records{};                          ///< must outlive the stack; null: it has its own
  bool has_robot{true};                            ///< false: no virtual Raven, the model moves alone
  double trial_limit{loop::kTrialLimit};           ///< [s] longest virtual trial; each second takes 160 KB
};

/** Newest states of a lockstep run. */
struct LockstepView {
  ModelState model{};
  RobotState robot{};
  HapticState haptic{};
};

/**
 * Console, daemon and virtual Raven in one thread, stepped together tick by tick. They exchange the same bytes that
 * otherwise cross the sockets, with pictures and pedals. There are no sockets, threads, clocks or files. It is faster
 * than real time, and gives the same states from the same seed and configuration. A process with nothing else may fork
 * it.
 *
 * Records are left in their rings: a caller takes them (Lockstep) or discards them.
 */
class LockstepStack {
 public:
  /** ODE must be initialised. @throw ModelException. */
  LockstepStack(const TrainerConfig& config,
                std::unique_ptr<console::MotionSource> source,
                const StackParts& parts = {});
  ~LockstepStack();

  /** One millisecond of everything. */
  void tick();

  /** The hands are done; the pedal stays up. */
  bool finished() const noexcept;

  /** From now on the link between console and daemon is bad, in both directions. Packets in flight are lost.
   *  @param[in] seed without one, the configuration's. */
  void impair(const Impairment& impairment, std::optional<std::uint64_t> seed = {});
  /** Hazards that are armed from now on draw from this seed instead of the configuration's. */
  void reseedHazards(std::uint64_t seed) noexcept;
  /** Signals for faults' triggers, from the next tick on. */
  void setSignals(const FaultSignals& signals) noexcept;
  /** Arms exactly this plan, in daemon and robot, from the next tick on; its generation is ignored. */
  void arm(const FaultPlan& plan);

  /** As soon as model and robot wait for the pedal this session is shown (mode `replaying`), and the surgeon waits for
   *  its end. Before the first tick. @throw SessionException as SessionPlayer::open(). */
  void showFirst(const std::string& session);

  /** The daemon's knowledge. */
  const LockstepView& view() const noexcept;
  /** Number of the console's newest ITP packet that has come through the link and the faults; 0 before the first. */
  std::uint32_t arrived() const noexcept;
  /** The truth: the robot's program, its plant, its PLC. */
  const RobotState& robot() const noexcept;
  const RavenReport& report() const noexcept;
  raven::DetectorReport detectorReport() const noexcept;
  JointArray trueJoints(Arm arm) const noexcept;
  RunLevel plcLevel() const noexcept;

  SharedState* shared() noexcept;
  std::vector<std::string> bodyNames() const;
  SessionCounts counts() const;
  void discardRecords() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::lockstep
