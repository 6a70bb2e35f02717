#include "raven2_trainer/recording/resimulation.h"

#include <filesystem>
#include <optional>

#include "force_check.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/loop/contact_records.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/recording/recorder.h"
#include "raven2_trainer/session/configuration_copy.h"
#include "raven2_trainer/session/record_difference.h"
#include "recording/input_queue.h"

namespace raven2_trainer::recording {
namespace {

constexpr Tick kProgressEvery = 100;

template <typename T, template <typename, std::size_t> class Ring, std::size_t Capacity>
void discard(Ring<T, Capacity>* ring) {
  T element;
  while (ring->tryPop(&element)) {
  }
}

template <typename T, std::size_t Capacity>
void push(SpscRing<T, Capacity>* ring, const T& element, Tick tick) {
  if (ring->tryPush(element)) return;
  throw SessionException("tick " + std::to_string(tick) + " consumed more than " + std::to_string(Capacity) +
                         " elements of one kind: it cannot be simulated again");
}

/** Of a session whose hands did what a program commanded: no plan was scheduled, whatever runtime.yaml says. */
bool isOfCommands(const std::string& motion) {
  return motion == "commands" || motion.rfind("commands over ", 0) == 0;
}

std::string nameOf(const ExerciseRecord& record) {
  return kExerciseEventNames[static_cast<std::size_t>(record.event.kind)];
}

void checkModelVersion(const session::SessionPaths& paths, int recorded) {
  if (recorded == kModelVersion) return;
  throw SessionException(paths.directory + ": recorded with version " + std::to_string(recorded) +
                         " of the nominal model, this program has version " + std::to_string(kModelVersion) +
                         " (doc/model.md, Versions): the session can be read and exported, but not simulated or scored "
                         "again");
}

}  // namespace

TrainerConfig sessionConfig(const session::SessionPaths& paths) {
  const session::LogHeader header = session::readLogHeader(paths.log());
  checkModelVersion(paths, header.model_version);
  const config::TrainingNames training{header.exercise, header.drill, header.trainee, header.curriculum};
  TrainerConfig config = config::loadTrainerConfig(session::checkConfiguration(paths, header), training);
  config::faultId(config, header.hazard);
  config.hazard = header.hazard;
  config.seed = header.seed;
  config.console.scale = header.motion_scale;
  config.model.arm_contacts = header.arm_contacts;
  if (isOfCommands(header.motion)) config.runtime.plan_at = -1.0;
  return config;
}

struct Resimulation::Impl {
  Impl(const TrainerConfig& configuration, const session::SessionPaths& session, const std::string& output)
      : config(configuration),
        paths(session),
        raven(model::loadRavenModel(config)),
        scene(model::loadSceneModel(config)),
        shared(std::make_unique<SharedState>()),
        physics(config, raven, scene, shared.get()),
        forces(config) {
    if (output.empty()) return;
    const std::string motion = session::readLogHeader(paths.log()).motion;
    recorder = std::make_unique<Recorder>(config, physics.bodyNames(), session::createSessionDirectory(output), motion,
                                          shared.get());
  }

  ResimulationResult run(const std::function<void(double)>& progress) {
    const auto size = static_cast<double>(std::filesystem::file_size(paths.log()));
    session::LogVisitor visitor;
    visitor.command = upToDifference<CommandRecord>([this](const auto& record) { commands.add(record); });
    visitor.request = upToDifference<RequestRecord>([this](const auto& record) { requests.add(record); });
    visitor.plan = upToDifference<PlanRecord>([this](const auto& record) {
      plans.add(record);
      forces.add(record);
    });
    visitor.faults = upToDifference<FaultRecord>([this](const auto& record) { faults.add(record); });
    visitor.fault_change = upToDifference<FaultChangeRecord>([this](const auto& record) {
      if (record.change.host == FaultHost::kRobot) changes.add(record);  // the others come again by themselves
    });
    visitor.execution = upToDifference<ExecutionRecord>([this](const auto& record) { executions.add(record); });
    visitor.exercise = upToDifference<ExerciseRecord>([this](const auto& record) { exercises.add(record); });
    visitor.contact = upToDifference<ContactRecord>([this](const auto& record) { contacts.add(record); });
    visitor.haptic = upToDifference<HapticRecord>([this](const auto& record) { addForce(record); });
    visitor.tick = upToDifference<TickRecord>([this](const auto& record) { tick(record); });
    visitor.counts = [this](const SessionCounts& record) { counts = record; };
    visitor.position = [&](std::uint64_t bytes) {
      if (!progress || shared->model.version() < reported + kProgressEvery) return;
      reported = shared->model.version();
      progress(static_cast<double>(bytes) / size);
    };
    session::readLog(paths.log(), visitor);
    if (!result.difference) result.difference = forces.compare(/*at_end=*/true, &result);
    finish();
    return result;
  }

  template <typename Record>
  std::function<void(const Record&)> upToDifference(std::function<void(const Record&)> use) {
    return [this, use](const Record& record) {
      if (!result.difference) use(record);
    };
  }

  void addForce(const HapticRecord& record) {
    forces.add(record);
    if (!recorder) return;
    shared->haptic_records.tryPush(record);
    recorder->follow();  // at its place among the ticks
  }

  void tick(const TickRecord& recorded) {
    const Tick expected = static_cast<Tick>(result.ticks) + 1;
    if (recorded.model.tick != expected) {
      throw SessionException(paths.log() + ": tick " + std::to_string(expected) +
                             " is missing: the session cannot be simulated again from there");
    }
    feed(recorded);
    physics.tick(recorded.model.time_ns);
    compare(recorded);
    drain();
    ++result.ticks;
  }

  /** Fills cells and rings as the tick found them. */
  void feed(const TickRecord& recorded) {
    const Tick now = recorded.model.tick;
    faults.take(now, [&](const FaultRecord& r) { shared->faults.store(r.plan); });
    changes.take(now, [&](const FaultChangeRecord& r) { push(&shared->fault_changes, r.change, now); });
    commands.take(now, [&](const CommandRecord& r) { push(&shared->master_commands, r.command, now); });
    requests.take(now, [&](const RequestRecord& r) { push(&shared->requests, r.request, now); });
    plans.take(now, [&](const PlanRecord& r) {
      if (r.refused == 0) push(&shared->plan_results, r.result, now);
    });
    feedReplay(recorded.model);
    shared->robot.store(recorded.robot);
    // With an exercise its judge gives them again, and the comparison covers them.
    if (config.exercise_name == "none") physics.setSignals(recorded.model.faults.signals);
    if (recorded.slipped != 0) physics.timeSlip();
  }

  /** A replayed session is in the ticks themselves, with its end. */
  void feedReplay(const ModelState& model) {
    const bool is_shown = model.mode == Mode::kReplaying;
    ReplayFrame frame;
    frame.is_last = is_shown ? 0 : 1;
    for (const Arm arm : kArms)
      at(frame.q, arm) = at(model.arms, arm).q;
    frame.bodies_W = model.bodies;
    if (is_shown || was_shown) push(&shared->replay_frames, frame, model.tick);
    was_shown = is_shown;
  }

  void compare(const TickRecord& recorded) {
    std::string field = session::difference(shared->model.load(), recorded.model);
    if (!field.empty()) field = "model." + field;
    const std::string contact = compareContacts(recorded.model.tick);
    if (field.empty()) field = contact;
    const std::string execution = compareExecution(recorded.model.tick);
    if (field.empty()) field = execution;
    const std::string exercise = compareExercise(recorded.model.tick);
    if (field.empty()) field = exercise;
    if (!field.empty()) result.difference = Difference{recorded.model.tick, field};
    forces.add(recorded);
    if (!result.difference) result.difference = forces.compare(/*at_end=*/false, &result);
  }

  std::string compareContacts(Tick now) {
    std::deque<ContactRecord> recorded;
    contacts.take(now, [&](const ContactRecord& r) { recorded.push_back(r); });
    std::string field;
    const auto differs = [&](const std::string& what) {
      if (field.empty() && !what.empty()) field = "contact." + what;
    };
    loop::forEachPair(shared->contacts.load(), [&](const ContactRecord& r) {
      if (recorded.empty()) return differs("points is " + std::to_string(r.points) + ", was not recorded");
      differs(session::difference(r, recorded.front()));
      recorded.pop_front();
    });
    if (!recorded.empty()) differs("points is 0, was " + std::to_string(recorded.front().points));
    return field;
  }

  /** The newest report of the tick: whatever is armed and given up within one tick is reported before it. */
  std::string compareExecution(Tick now) {
    std::optional<ExecutionRecord> recorded;
    executions.take(now, [&](const ExecutionRecord& r) { recorded = r; });
    const bool is_reported = shared->last_execution.version() != reports;
    reports = shared->last_execution.version();
    if (is_reported != recorded.has_value())
      return is_reported ? "execution.report was not recorded" : "execution.report is missing";
    if (!is_reported) return "";
    const std::string field = session::difference(ExecutionRecord{now, shared->last_execution.load()}, *recorded);
    return field.empty() ? "" : "execution." + field;
  }

  /** Compares the events of the exercise, in order; those that found their ring full were never recorded. */
  std::string compareExercise(Tick now) {
    std::deque<ExerciseRecord> recorded;
    exercises.take(now, [&](const ExerciseRecord& r) { recorded.push_back(r); });
    const auto& ring = shared->exercise_records;
    std::string field;
    for (; events < ring.tail() && field.empty(); ++events) {
      if (recorded.empty()) return "exercise." + nameOf(ring.at(events)) + " was not recorded";
      field = session::difference(ring.at(events), recorded.front());
      recorded.pop_front();
    }
    if (!field.empty()) return "exercise." + field;
    return recorded.empty() ? "" : "exercise." + nameOf(recorded.front()) + " is missing";
  }

  void drain() {
    discard(&shared->plan_requests);
    discard(&shared->relay_packets);
    discard(&shared->force_packets);
    discard(&shared->replay_frames);  // whatever ended it came before
    if (recorder) return recorder->follow();
    discard(&shared->tick_records);
    discard(&shared->command_records);
    discard(&shared->request_records);
    discard(&shared->plan_records);
    discard(&shared->fault_records);
    discard(&shared->change_records);
    discard(&shared->execution_records);
    discard(&shared->exercise_records);
    discard(&shared->contact_records);
  }

  /** The counters of links and loops are those of the session. */
  void finish() {
    if (!recorder) return;
    recorder->drain();
    recorder->finish(counts);
  }

  const TrainerConfig config;
  const session::SessionPaths paths;
  const model::RavenModel raven;
  const model::SceneModel scene;
  std::unique_ptr<SharedState> shared;
  loop::PhysicsLoop physics;
  ForceCheck forces;
  std::unique_ptr<Recorder> recorder;

  InputQueue<CommandRecord> commands{"a command"};
  InputQueue<RequestRecord> requests{"a request"};
  InputQueue<PlanRecord> plans{"a plan"};
  InputQueue<FaultRecord> faults{"a fault plan"};
  InputQueue<FaultChangeRecord> changes{"a robot's fault"};
  InputQueue<ContactRecord> contacts{"a contact"};
  InputQueue<ExecutionRecord> executions{"an execution"};
  InputQueue<ExerciseRecord> exercises{"an event of the exercise"};
  SessionCounts counts{};
  ResimulationResult result;
  bool was_shown{false};
  std::uint64_t reported{0};
  std::uint64_t events{0};  ///< of the exercise, compared so far; the recorder may keep them in their ring
  std::uint64_t reports{shared->last_execution.version()};
};

Resimulation::Resimulation(const TrainerConfig& config, const session::SessionPaths& paths, const std::string& output)
    : impl_(std::make_unique<Impl>(config, paths, output)) {}

Resimulation::~Resimulation() = default;

ResimulationResult Resimulation::run(const std::function<void(double)>& progress) {
  return impl_->run(progress);
}

}  // namespace raven2_trainer::recording
