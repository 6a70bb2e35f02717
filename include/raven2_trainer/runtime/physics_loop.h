#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/control/camera_orbit.h"
#include "raven2_trainer/control/mode_table.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/return_path.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/faults/packet_stream.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/runtime/exercise_desk.h"
#include "raven2_trainer/runtime/model_driver.h"
#include "raven2_trainer/runtime/plan_desk.h"
#include "raven2_trainer/runtime/servo_desk.h"
#include "raven2_trainer/runtime/trial_desk.h"

namespace raven2_trainer::runtime {

/**
 * Body of the physics thread: masters' increments to desired joints, controllers, one ODE step, the relay to the robot,
 * and the mode table. Owner of the live world. tick() is real-time safe once warm.
 *
 * Linking model and robot: while the pedal is up and the robot's state is fresh, the model's controllers bring it to
 * the robot's joints (what the jaws hold stays held); at pedal down it is put exactly there, and both start from one
 * pose. Increments count for neither until the robot reports PEDAL_DN, so that both apply the same ones. A robot that
 * hears no packets (the last sequence that it reports stands still) and is not in PEDAL_DN is sent pedal-up until the
 * surgeon's next pedal-down: a press that it did not hear does not engage it when it hears again. If the robot's link
 * is lost while engaged, the model goes on alone and the robot is sent pedal-up until the surgeon's next pedal-down: it
 * never moves, nor does the cue act, without a new start from a common pose.
 *
 * Planning and executing (PlanDesk keeps what is asked): while a goal is chosen the world stands still but for the arm
 * that is moved, kinematically; what the jaws hold stays where it is, and the arm comes back to it. A plan is executed
 * while the pedal is held, from the common pose of pedal-down: the model by its controllers, the robot by increments
 * through the same relay. Whatever ends it (the pedal, E-stop, a lost link, too large a deviation) ends it for both in
 * the same tick.
 *
 * Away from the robot: pure simulation and virtual trials (TrialDesk keeps what is done) move the model alone, and it
 * holds with the pedal up. Before it is linked again it glides back through everything, with the pedal up; a pedal-down
 * waits for that. A trial is repeated as a plan is executed, by both arms. While a recorded session is shown nothing is
 * stepped; whatever ends that puts the arms back to where they stood.
 *
 * CRTK clients are one more master (ServoDesk): what they ask for comes as commands beside the console's, and is
 * recorded, corrupted, taken and relayed as those are.
 */
class PhysicsLoop {
 public:
  PhysicsLoop(const TrainerConfig& config,
              const model::RavenModel& raven,
              const model::SceneModel& scene,
              SharedState* shared,
              double trial_limit = kTrialLimit);

  /** Advances the nominal model by one 1 ms step. @param[in] now_ns CLOCK_MONOTONIC; in lockstep tick x 1e6. */
  void tick(std::int64_t now_ns) noexcept;

  /** Simulated time was given up (CyclicThread): pauses the exercise and unlinks the robot until the next pedal-down.
   */
  void timeSlip() noexcept;
  /** The same at the next tick, from any thread: another loop of the exercise gave up time. */
  void requestPause() noexcept { pause_requested_.store(true, std::memory_order_relaxed); }

  /** What faults' triggers look at, from the next tick on; from the thread of the ticks. */
  void setSignals(const FaultSignals& signals) noexcept { state_.faults.signals = signals; }

  /** Bodies by the numbers of contacts. */
  const std::vector<std::string>& bodyNames() const noexcept { return world_.bodyNames(); }

 private:
  struct Increments {
    PerArm<Vec3> dp_I{};
    PerArm<Quat> dq_I{{kIdentityQuat, kIdentityQuat}};
    PerArm<double> dgrasp{};
    std::uint32_t commands{};
    std::uint32_t last_sequence{};
  };

  void readInputs(std::int64_t now_ns) noexcept;
  void readFaults() noexcept;
  void drainCommands() noexcept;
  void consume(const MasterCommand& command) noexcept;
  void takeCommand(const MasterCommand& command) noexcept;
  bool mayInject() const noexcept;
  bool hasRobot() const noexcept { return robot_.connected != 0 && robot_.frame > 0; }
  void holdFaults() noexcept;
  void tellFaultChanges() noexcept;
  void countFaultedPackets() noexcept;
  void corruptMaster(const MasterCommand& command) noexcept;
  void takeHeldCommands() noexcept;
  void corruptConsole() noexcept;
  bool fits(const MasterCommand& command) const noexcept;
  void drainRequests() noexcept;
  void handleRequest(const Request& request) noexcept;
  void handlePlanResult(const PlanResult& result) noexcept;
  void forgetOldRobot() noexcept;
  void scheduledPlan() noexcept;
  void updateTargets() noexcept;
  void aimAsTold() noexcept;
  void useCommands() noexcept;
  void dropMotion() noexcept;
  void moveModel() noexcept;
  void driveModel(const PerArm<JointArray>& target) noexcept;
  void relay() noexcept;
  void sendToRobot(const RelayPacket& packet) noexcept;
  void publish(std::int64_t now_ns) noexcept;
  void listContacts() noexcept;
  void publishContacts() noexcept;
  void fillArm(Arm arm, ArmState* state) const noexcept;

  // modes, what is asked for, and how model and robot are kept together: physics_modes.cpp
  void updateRobotEvents() noexcept;
  void updateRunLevelEvents() noexcept;
  void updatePedal() noexcept;
  void enter(Mode next) noexcept;
  void rebaseArms() noexcept;
  void raise(control::Event event) noexcept;
  PlanningAnswer ask(control::Event event) noexcept;
  void listenToRobot() noexcept;
  bool isRobotDeaf() const noexcept;
  bool isRobotLed() const noexcept { return linked_ && !is_unheard_; }
  bool robotApplies() const noexcept;
  bool robotJoins() const noexcept;
  bool isRobotThere() const noexcept { return state_.robot_fresh != 0 && robot_ready_; }
  bool isRobotLost() const noexcept { return !hasRobot() || robot_silent_; }
  bool isRobotNotReady() const noexcept { return state_.robot_fresh != 0 && !robot_ready_; }
  std::uint8_t heldPedal() const noexcept { return !pedal_ ? 0 : is_clients_ ? kClientsPedal : kSurgeonsPedal; }
  bool isPedalUp() const noexcept { return !pedal_ && !pedal_before_; }
  bool mayBegin() const noexcept { return isPedalUp() && !isRobotNotReady(); }
  JointArray followRobot(Arm arm) noexcept;
  JointArray bringTo(Arm arm, const JointArray& wanted) noexcept;
  void joinRobot() noexcept;
  void serveTraining(const Request& request) noexcept;
  PlanningAnswer answerTraining(const Request& request) noexcept;
  void stop() noexcept;
  PlanningAnswer clearStop() noexcept;
  PlanningAnswer changeTool() noexcept;
  PlanningAnswer restartExercise() noexcept;
  PlanningAnswer pressCamera(CameraPedal pedal) noexcept;
  void moveCamera() noexcept;
  void leaveRobot() noexcept;
  void takeOpenings() noexcept;
  bool mustReturn() const noexcept { return is_apart_ && isRobotThere(); }
  bool waitsForReturn() noexcept;
  void beginReturn() noexcept;
  bool isAstray(const PerArm<JointArray>& from) const noexcept;
  void superviseReturn() noexcept;
  PerArm<JointArray> robotJoints() const noexcept;
  PerArm<JointArray> standing() const noexcept;

  // virtual trials: physics_trial.cpp
  PlanningAnswer beginTrial() noexcept;
  PlanningAnswer discardTrial() noexcept;
  void endRehearsal() noexcept;
  PlanningAnswer repeatTrial(const Request& request) noexcept;
  PlanningAnswer checkRepeat(const Request& request) const noexcept;
  void superviseTrial() noexcept;
  void armRepeat() noexcept;
  void repeat() noexcept;
  void settleTrial(Mode next, control::Event event) noexcept;

  // recorded sessions: physics_replay.cpp
  PlanningAnswer beginReplay(const Request& request) noexcept;
  void superviseReplay() noexcept;
  bool isReplayOver() noexcept;
  void showReplay() noexcept;
  void standAgain() noexcept;

  // CRTK clients: physics_servo.cpp
  void drainConsole() noexcept;
  void serveClients() noexcept;
  ServoStand servoStand() const noexcept;
  void pushModel(const Request& request) noexcept;
  const PerArm<JointArray>& robotSetPoints() noexcept;

  // planning and executing: physics_planning.cpp
  Tick thisTick() const noexcept { return state_.tick + 1; }
  void requestPlan(Request request) noexcept;
  std::uint32_t nextOwnId() noexcept;
  void cancelPlan(const Request& request) noexcept;
  void beginChoosing(const Request& request) noexcept;
  void recordGoal(Request request) noexcept;
  void endChoosing(const Request& request) noexcept;
  void moveGoal() noexcept;
  void showGoal() noexcept;
  void armPlan(const Request& request) noexcept;
  bool hasMoved() noexcept;
  bool mayPress() noexcept;
  void beginExecution() noexcept;
  void execute() noexcept;
  void aimAtPath(Arm arm, const JointArray& q) noexcept;
  void superviseExecution() noexcept;
  void endExecution(ExecutionEnd end) noexcept;
  void disarm(ExecutionEnd end) noexcept;
  void loseRobot() noexcept;
  bool movesRobot() const noexcept;
  static ExecutionEnd endBy(control::Event event) noexcept;
  void endUnderWay(ExecutionEnd end) noexcept;
  bool mayMoveOn() const noexcept;
  void settlePlanning(Mode next, control::Event event) noexcept;
  void placeForPlanning(Mode before, Mode next) noexcept;
  JointArray modelJoints(Arm arm) const noexcept;

  const TrainerConfig& config_;
  SharedState& shared_;
  physics::RavenWorld world_;
  PerArm<control::TeleopMapper> mappers_;
  ModelDriver driver_;
  control::PathFollower follower_;
  PlanDesk desk_;
  TrialDesk trial_;
  control::ReturnPath return_;
  control::CameraOrbit camera_;
  ExerciseDesk exercise_;
  ServoDesk servo_;
  faults::FaultEngine relay_faults_{FaultHost::kRelay}, master_faults_{FaultHost::kMaster},
      console_faults_{FaultHost::kConsole};
  faults::CommandStream relay_stream_{FaultVariable::kPacket}, master_stream_{FaultVariable::kPacket};
  std::int64_t stale_ns_, lost_ns_;
  Tick silence_limit_;

  ModelState state_{};
  RobotState robot_{};
  ContactList contacts_{};
  Increments increments_{};
  PerArm<JointArray> q_d_{};
  PerArm<JointArray> robot_q_d_{};  ///< what the robot is asked for, as far as is known here
  JointArray path_lead_{};          ///< [rad; m] kExecuting: what the arm on its path is asked for
  bool robot_took_{false};          ///< kExecuting: the robot was sent a piece of the path
  PerArm<bool> collisions_{};       ///< as configured and asked for
  bool pedal_{false}, pedal_before_{false};
  bool is_clients_{false};           ///< the newest command was a CRTK client's pedal-down
  Tick silent_ticks_{0};             ///< since the last master command
  bool robot_ready_{false};          ///< homed was seen
  bool robot_there_{false};          ///< it was ready and heard in the tick before
  bool robot_silent_{true};          ///< its newest state is older than lost_ns_
  bool linked_{false};               ///< model and robot started from a common pose and nothing came between
  bool is_unheard_{false};           ///< linked, and the robot was deaf to it: until the next pedal-down
  bool tells_sequence_{false};       ///< the last sequence that this robot reports has changed once: some report none
  std::uint32_t heard_sequence_{0};  ///< the newest that it reported
  std::uint64_t heard_cycle_{0};     ///< its cycle in which it did first
  bool plan_scheduled_{false};
  bool stopped_by_robot_{false};
  bool stop_asked_{false};            ///< by request or pedal
  bool is_apart_{false};              ///< the model left the robot on purpose
  PerArm<double> joint_opening_{};    ///< [rad] of the jaws, wanted when it left, and with which it comes back
  Mode camera_from_{Mode::kPedalUp};  ///< kCameraMoving: what it was before
  std::uint32_t tool_changes_{0};
  physics::SceneSnapshot trial_scene_{};       ///< when the trial began
  bool rehearses_{false};                      ///< what happens now will be put back to that
  std::uint32_t replay_{0};                    ///< Request::plan of the newest replay
  ReplayFrame shown_{};                        ///< kReplaying
  PerArm<JointArray> stood_q_{}, stood_dq_{};  ///< before it
  std::uint32_t relay_sequence_{0};
  bool relay_started_{false};  ///< a robot was there once: it hears from us every tick from then on
  bool relay_in_step_{false};  ///< our numbering follows the one the robot echoed
  std::uint32_t next_plan_id_{0};
  std::uint64_t last_cycle_{0};
  std::atomic<bool> pause_requested_{false};
  std::uint64_t fault_generation_{~std::uint64_t{0}};  ///< of the plan in force
  std::uint64_t changes_untold_{0};
  bool slipped_{false};  ///< since the last tick
};

}  // namespace raven2_trainer::runtime
