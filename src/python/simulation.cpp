#include "python/simulation.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_impairment.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/console/commands_file.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/recording/recorder.h"
#include "raven2_trainer/recording/start_meta.h"

namespace raven2_trainer::python {
namespace {

std::atomic<std::uint64_t> simulations{0};
const std::string kCommands = "commands";  ///< motion from step()
constexpr int kInterruptTicks = 1000;
constexpr Tick kPictureTicks = 33;         ///< from a live picture to the next
constexpr double kMaxTurn = 0.0989;        ///< [rad] in a tick; less than a packet of the console takes
constexpr double kLag = 2e-3;              ///< [m] farther behind its set point no arm is at rest; ours
constexpr double kLagTurn = 0.2;           ///< [rad] the same

/** Text of an exception, without the beginning that the next one's constructor adds again. */
std::string reasonOf(const Exception& exception) {
  const std::string text = exception.what(), beginning = Exception("").what();
  return text.rfind(beginning, 0) == 0 ? text.substr(beginning.size()) : text;
}

}  // namespace

TrainerConfig loadConfig(const SimulationOptions& options) {
  if (console::isCommanded(options.motion))
    throw std::invalid_argument("motion is \"" + options.motion + "\": only the program simulate repeats a file");
  const std::string root = options.config.empty() ? config::shareFolder() + "/config/trainer.yaml" : options.config;
  const bool has_exercise = options.exercise != "none";
  config::TrainingNames names;
  names.exercise = options.exercise;
  names.drill = has_exercise ? options.hazard : "none";
  TrainerConfig loaded = config::loadTrainerConfig(root, names, options.settings);
  if (!options.plant.empty()) config::selectPlant(&loaded, options.plant);
  loaded.seed = options.seed;
  if (!has_exercise) loaded.hazard = options.hazard;
  config::checkHazard(loaded);
  demandRobotFor(loaded, has_exercise ? loaded.drill : loaded.hazard, options.has_robot);
  loaded.virtual_raven.full_homing = false;
  if (options.motion == kCommands) loaded.runtime.plan_at = -1.0;  // the model moves as commanded alone
  return loaded;
}

namespace {

std::string labelOf(const SimulationOptions& options) {
  return options.motion + (options.link == "none" ? "" : " over " + options.link);
}

double limited(double opening) noexcept {
  return std::clamp(opening, control::kMinOpening, control::kMaxOpening);
}

Vector3 toItp(const Vector3& v_W) noexcept {
  return {v_W.x(), -v_W.y(), -v_W.z()};
}

Quat quaternionOf(const Vector3& rotation) noexcept {
  const double angle = rotation.norm();
  if (angle < 1e-12) return kIdentityQuat;
  return toArray(Quaternion(Eigen::AngleAxisd(angle, rotation / angle)));
}

/** Rotation that does not fit into its packets would follow in later ticks, after the set point is due. */
void demandSlowTurn(Arm arm, const Matrix3& from, const Matrix3& to, int ticks) {
  const double turn = Eigen::AngleAxisd(Matrix3(to * from.transpose())).angle() / ticks;
  if (turn <= kMaxTurn) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s: joints turn the tool by %.3g rad in a tick, at most %.3g rad: take more ticks",
                name(arm), turn, kMaxTurn);
  throw std::invalid_argument(text);
}

}  // namespace

/** The session on the disk. */
class Simulation::Recording {
 public:
  Recording(const TrainerConfig& config, const SimulationOptions& options, lockstep::LockstepStack* stack)
      : config_(config),
        stack_(*stack),
        paths_(session::createSessionDirectory(
            std::filesystem::absolute(options.output))),  // a later chdir changes nothing
        meta_(recording::startMeta("python", RAVEN2_TRAINER_VERSION, labelOf(options))),
        recorder_(config, stack->bodyNames(), paths_, labelOf(options), stack->shared()) {
    writeMeta("unknown: not ended cleanly");  // also of a session that is killed
    if (options.motion != kCommands) return;
    commands_file_.open(paths_.directory + "/commands.csv");
    if (!commands_file_) throw SessionException(paths_.directory + "/commands.csv cannot be written");
    commands_.emplace(&commands_file_);
  }

  void note(const console::HandsCommand& command) { commands_->add(command); }
  void follow() { recorder_.follow(); }
  void finish() {
    if (commands_) commands_->flush();  // whatever comes of the rest
    if (commands_) commands_file_.close();
    recorder_.drain();  // the counts include it
    recorder_.finish(stack_.counts());
    writeMeta("lockstep");
    recording::finishSession(paths_);
    if (commands_ && !commands_file_) throw SessionException(paths_.directory + "/commands.csv cannot be written");
  }

 private:
  void writeMeta(const char* realtime) {
    meta_.wall_duration = std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
    meta_.realtime = realtime;
    session::writeMeta(paths_, meta_, config_);
  }

  const std::chrono::steady_clock::time_point started_{std::chrono::steady_clock::now()};
  const TrainerConfig& config_;
  lockstep::LockstepStack& stack_;
  const session::SessionPaths paths_;
  session::SessionMeta meta_;
  recording::Recorder recorder_;
  std::ofstream commands_file_;
  std::optional<console::CommandWriter> commands_;
};

Simulation::Simulation(const SimulationOptions& options)
    : number_(++simulations),
      config_(loadConfig(options)),
      link_(config::findImpairment(config::impairmentFolder(options.config), options.link)),
      raven_(std::make_shared<model::RavenModel>(model::loadRavenModel(config_))),
      scene_(std::make_shared<model::SceneModel>(model::loadSceneModel(config_))),
      records_(std::make_unique<RecordRings>()),
      process_(getpid()),
      has_robot_(options.has_robot) {
  physics::initialiseOde();
  std::string wrong_setting, wrong_model, trouble;
  const OdeBuilding building;
  try {
    build(options);
  } catch (const ConfigException& e) {
    wrong_setting = reasonOf(e);  // the exceptions may have memory in the arena, which goes
  } catch (const ModelException& e) {
    wrong_model = reasonOf(e);
  } catch (const std::exception& e) {
    trouble = e.what();
  }
  try {
    if (!wrong_setting.empty()) throw ConfigException(wrong_setting);
    if (!wrong_model.empty()) throw ModelException(wrong_model);
    if (!trouble.empty()) throw std::runtime_error(trouble);
    if (!options.output.empty()) recording_ = std::make_unique<Recording>(config_, options, stack_.get());
  } catch (...) {  // here, as in the destructor: ODE may keep no block of the arena
    destroyStack();
    throw;
  }
}

void Simulation::destroyStack() {
  const ArenaScope scope(&arena_);
  pictures_.reset();
  stack_.reset();
}

void Simulation::build(const SimulationOptions& options) {
  const ArenaScope scope(&arena_);
  const double opening = kinematics::jawOpening(config_.arms.geometry.home);
  std::unique_ptr<console::MotionSource> hands;
  if (options.motion == kCommands) {
    auto commanded = std::make_unique<console::CommandedSource>(config_.console, PerArm<double>{opening, opening});
    source_ = commanded.get();
    hands = std::move(commanded);
  } else {
    hands = console::makeMotion(config_, options.motion);
  }
  lockstep::StackParts parts;
  parts.raven = raven_;
  parts.scene = scene_;
  parts.records = records_.get();
  parts.has_robot = options.has_robot;
  parts.trial_limit = 0.1;  // a program has save() and restore()
  stack_ = std::make_unique<lockstep::LockstepStack>(config_, std::move(hands), parts);
  if (options.link != "none") stack_->impair(link_);
  pictures_ = std::make_unique<render::PictureLine>();
}

Simulation::~Simulation() {
  if (getpid() != process_)
    static_cast<void>(recording_.release());  // its files are the parent's, and stay as they are
  recording_.reset();
  physics::attachOdeToThread();
  const OdeBuilding building;
  destroyStack();
}

void Simulation::demandOpen() const {
  if (is_closed_) throw std::runtime_error("the simulation is closed");
  if (recording_ && getpid() != process_)
    throw std::runtime_error(
        "a recorded simulation is stepped by the process that made it, not by one that was forked from it");
}

void Simulation::demandHands(const StepCommand& command) const {
  if (source_ == nullptr && !command.is_none)
    throw std::invalid_argument("step: a simulated surgeon has the hands: no command, or motion=None");
}

/** [m] Along an axis in a tick, less what rounding may add. */
double Simulation::largestMove() const {
  return 1e-6 * (config_.network.itp.max_increment_um - 1);
}

/** A packet with more than its limit would be refused whole, and nothing would move. */
void Simulation::demandSlow(Arm arm, const ArmCommand& command, int ticks) const {
  const double turn = toEigen(command.turn_W).norm() / ticks;
  if (!(turn <= kPi))
    throw std::invalid_argument(std::string(name(arm)) + ": turn is over 3.14 rad in a tick: take more ticks");
  Pose from, to{Matrix3::Identity(), toEigen(command.move_W)};
  if (command.joints) {
    from = led(arm);
    to = kinematics::forward(config_.arms.geometry, arm, *command.joints);
  }
  const double largest = (to.p - from.p).cwiseAbs().maxCoeff() / ticks;
  if (largest > largestMove()) {
    char text[160];
    std::snprintf(text, sizeof text, "%s: %.3g mm in a tick, at most %.3g mm along an axis: take more ticks", name(arm),
                  1e3 * largest, 1e3 * largestMove());
    throw std::invalid_argument(text);
  }
  demandSlowTurn(arm, from.R, to.R, ticks);
}

void Simulation::tick() {
  asked_ = {};
  {
    const ArenaScope scope(&arena_);
    stack_->tick();
    if (!recording_) stack_->discardRecords();
  }
  if (view().model.tick % kPictureTicks == 0) passPicture();
  if (source_ != nullptr) {
    under_way_.add(source_->sequence(), source_->done(), source_->mayMove());
    under_way_.arrived(stack_->arrived());
  }
  if (recording_ && source_ != nullptr) recording_->note(source_->done());
  if (recording_) recording_->follow();
}

render::Snapshot Simulation::passPicture() {
  render::Snapshot now;
  now.model = view().model;
  now.robot = view().robot;
  now.haptic = view().haptic;
  const ArenaScope scope(&arena_);
  return pictures_->pass(now);
}

void Simulation::demand(const StepCommand& command, int ticks) const {
  demandOpen();
  demandHands(command);
  for (const Arm arm : kArms)
    demandSlow(arm, at(command.arms, arm), ticks);
}

void Simulation::check(const StepCommand& command, int ticks) const {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demand(command, ticks);
}

void Simulation::step(const StepCommand& command, int ticks, const std::function<void()>& interrupt) {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demand(command, ticks);
  physics::attachOdeToThread();
  for (const Arm arm : kArms) {
    const ArmCommand& wanted = at(command.arms, arm);
    if (!command.pedal) continue;
    if (wanted.jaw) at(jaws_, arm) = limited(*wanted.jaw);
    if (wanted.joints) at(jaws_, arm) = limited(kinematics::jawOpening(*wanted.joints));
  }
  for (int left = ticks; left > 0; --left) {
    if (left % kInterruptTicks == 0) {
      interrupt();
      demandOpen();
    }
    if (source_ != nullptr) source_->set(handsFor(command, ticks, left));
    tick();
  }
}

int Simulation::start(int limit, const std::function<void()>& interrupt) {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  physics::attachOdeToThread();
  if (source_ != nullptr) {
    console::HandsCommand rest;
    rest.grasp = {source_->grasp(Arm::kGold), source_->grasp(Arm::kGreen)};
    source_->set(rest);
  }
  for (int ticks = 0; ticks <= limit; ++ticks) {
    const bool may_move = source_ == nullptr || source_->mayMove();
    const ModelState& model = view().model;
    const bool waits = has_robot_ ? model.mode == Mode::kPedalUp : traitsOf(model.mode).follows_robot;
    if (model.tick > 0 && may_move && waits) return ticks;
    if (ticks == limit) break;
    if (ticks % kInterruptTicks == kInterruptTicks - 1) {
      interrupt();
      demandOpen();
    }
    tick();
  }
  throw std::runtime_error("the arms are not ready after " + std::to_string(limit) + " ticks");
}

console::HandsCommand Simulation::handsFor(const StepCommand& command, int ticks, int left) {
  console::HandsCommand hands;
  hands.pedal = command.pedal;
  for (const Arm arm : kArms) {
    const ArmCommand& wanted = at(command.arms, arm);
    at(hands.grasp, arm) = graspFor(arm, command.pedal);
    if (wanted.joints) {
      approach(arm, *wanted.joints, left, &hands);
      continue;
    }
    const double share = 1.0 / ticks;
    at(hands.move_I, arm) = toArray(Vector3(share * toItp(toEigen(wanted.move_W))));
    at(hands.turn_I, arm) = quaternionOf(share * toItp(toEigen(wanted.turn_W)));
  }
  return hands;
}

/** ITP has increments of the jaws alone: this adds what they lack of the command. */
double Simulation::graspFor(Arm arm, bool pedal) const {
  const double sent = source_->grasp(arm);
  if (!pedal || !at(jaws_, arm) || !source_->mayMove()) return sent;
  const double led = kinematics::jawOpening(at(view().model.arms, arm).q_d) + under_way_.of(arm).grasp;
  return sent + *at(jaws_, arm) - led;
}

/** Where everything sent so far leads the tool: the model's desired pose, and what is under way. */
Pose Simulation::led(Arm arm) const {
  Pose pose = kinematics::forward(config_.arms.geometry, arm, at(view().model.arms, arm).q_d);
  const Matrix3 I_to_B = control::itpToBase(arm);
  const UnderWay::Motion coming = under_way_.of(arm);
  pose.p += I_to_B * toEigen(coming.move_I);
  if (coming.turn_I == kIdentityQuat) return pose;
  const Matrix3 turn_I = toEigen(coming.turn_I).normalized().toRotationMatrix();
  pose.R = I_to_B * turn_I * I_to_B.transpose() * pose.R;
  return pose;
}

/** Toward the pose of the joints, so that what was rounded before counts. An arm that is so far behind that it refuses
 *  its set points must catch up first: only what leads it back is sent, as nothing shows how much it refused. Once it
 * has caught up and still refuses, it was led too far before. A pose that does not come nearer asks for more in each
 * tick that is left: at most for what a packet may carry. */
void Simulation::approach(Arm arm, const JointArray& joints, int left, console::HandsCommand* hands) const {
  const ArmState& state = at(view().model.arms, arm);
  const Pose now = led(arm);
  const Pose goal = kinematics::forward(config_.arms.geometry, arm, joints);
  const Pose is = kinematics::forward(config_.arms.geometry, arm, state.q);
  const bool lags =
      (is.p - now.p).norm() > kLag || Eigen::AngleAxisd(Matrix3(is.R * now.R.transpose())).angle() > kLagTurn;
  const auto status = static_cast<kinematics::IkStatus>(state.ik_status);
  const bool is_behind = lags && status == kinematics::IkStatus::kTooFar;
  Vector3 way = goal.p - now.p;
  if (is_behind) {
    const Vector3 back = (is.p - now.p).normalized();
    way = std::max(0.0, way.dot(back)) * back;
  }
  const Matrix3 B_to_I = control::itpToBase(arm).transpose();
  const Eigen::AngleAxisd turn(Matrix3(goal.R * now.R.transpose()));
  Vector3 move_I = B_to_I * way / left;
  const double most = largestMove(), largest = move_I.cwiseAbs().maxCoeff();
  if (largest > most) move_I *= most / largest;
  at(hands->move_I, arm) = toArray(move_I);
  if (is_behind) return;
  const double angle = std::min(turn.angle() / left, kMaxTurn);
  at(hands->turn_I, arm) = quaternionOf(B_to_I * (angle * turn.axis()));
}

Snapshot Simulation::save() {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  if (recording_) throw std::runtime_error("a recorded simulation cannot go back: save() needs one without output");
  return {{}, number_, jaws_, under_way_, asked_, arena_.copy()};
}

void Simulation::restore(const Snapshot& snapshot) {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  if (snapshot.owner != number_) throw std::invalid_argument("the snapshot is another simulation's");
  jaws_ = snapshot.jaws;
  under_way_ = snapshot.under_way;
  asked_ = snapshot.asked;
  arena_.restore(snapshot.memory);
}

void Simulation::reseed(std::uint64_t seed) {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  if (recording_) throw std::runtime_error("a recorded simulation has one seed: reseed() needs one without output");
  const ArenaScope scope(&arena_);
  stack_->reseedHazards(seed);
  if (link_.name != "none") stack_->impair(link_, seed);
}

void Simulation::close() {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  if (!end_trouble_.empty()) throw SessionException(end_trouble_);
  if (is_closed_) return;
  demandOpen();
  is_closed_ = true;
  if (!recording_) return;
  try {
    recording_->finish();
  } catch (const SessionException& e) {
    end_trouble_ = reasonOf(e);
    throw;
  }
}

}  // namespace raven2_trainer::python
