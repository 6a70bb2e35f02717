#include "raven2_trainer/recording/recorder.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/session/configuration_copy.h"

namespace raven2_trainer::recording {
namespace {

constexpr std::int64_t kRetryNs = 500'000'000;  // [ns] a quarter of the 2 s that the queues hold
constexpr std::int64_t kSyncNs = 900'000'000;   // [ns] every other batch: what a loss of power can cost
// Longer batches are hardly smaller: 0.1 s 643, 0.25 s 620, 0.5 s 607, 1 s 600 bytes a tick of teleoperation
// (measured, without formulas).
constexpr Tick kBatch = 500;                // [ms]
constexpr std::uint64_t kLargestShare = 3;  // of a queue: a third is written before its time
constexpr std::size_t kMostParts = 2 * kBatch;

/** Kinds of record that the metrics are made from. */
template <typename Record, typename = void>
struct CountsForMetrics : std::false_type {};
template <typename Record>
struct CountsForMetrics<
    Record,
    std::void_t<decltype(std::declval<training::MetricsAccumulator&>().add(std::declval<const Record&>()))>>
    : std::true_type {};

RecordTally minus(const RecordTally& a, const RecordTally& b) noexcept {
  RecordTally difference{};
  for (std::size_t k = 0; k < kRecordKindCount; ++k)
    difference[k] = a[k] - b[k];
  return difference;
}

std::string combinedHash(const TrainerConfig& config) {
  std::string hashes;
  for (const std::string& file : config.files)
    hashes += session::readHash(config, file);
  return hashes;
}

/** Everything that a session is configured by, so that it can be simulated again. */
std::vector<std::string> configurationFiles(const TrainerConfig& config) {
  std::vector<std::string> files = config.files;
  std::error_code none;
  for (const auto& plant : std::filesystem::directory_iterator(config.virtual_raven.plants_folder, none)) {
    const bool is_plant = plant.path().extension() == ".yaml" && plant.is_regular_file(none);
    if (is_plant) files.push_back(plant.path().string());  // the packaged files name one, whichever was chosen
  }
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(config.files.size()), files.end());
  for (const std::string& urdf : {config.robot_urdf, config.scene_urdf}) {
    files.push_back(urdf);
    for (const std::string& mesh : model::meshFiles(urdf))
      files.push_back(mesh);
  }
  return files;
}

/** A URDF of the package is next to the configuration, with its meshes next to it. */
std::map<std::string, std::string> placesOf(const TrainerConfig& config) {
  std::map<std::string, std::string> places;
  for (const auto& [urdf, place] : config.urdf_places) {
    if (urdf == place) continue;
    const std::filesystem::path from = std::filesystem::path(urdf).parent_path();
    const std::filesystem::path to = std::filesystem::path(place).parent_path();
    places[urdf] = place;
    for (const std::string& mesh : model::meshFiles(urdf))
      places[mesh] = (to / std::filesystem::path(mesh).lexically_relative(from)).lexically_normal().string();
  }
  return places;
}

/** The camera that the metric out_of_view asks for (config/render.yaml: that of the live picture). */
session::HeaderCamera scoredCamera(const RenderConfig& render) {
  if (render.cameras.empty()) return {};
  const CameraConfig& camera = liveCamera(render);
  return {camera.name, camera.vertical_fov, 1.0 * render.live_width / render.live_height};
}

void describeTraining(const TrainerConfig& config, session::LogHeader* header) {
  header->exercise = config.exercise_name;
  header->drill = config.drill;
  header->trainee = config.trainee;
  header->curriculum = config.curriculum;
  header->motion_scale = config.console.scale;
  header->hand = {config.console.hand_mass, config.console.hand_stiffness, config.console.hand_damping};
  header->camera = scoredCamera(config.render);
  for (const ExerciseTrack& track : config.exercise.tracks) {
    header->step_names.emplace_back();
    for (const ExerciseStep& step : track.steps)
      header->step_names.back().push_back(step.name);
  }
  for (const SceneObject& object : config.roles.objects)
    header->object_names.push_back(object.name);
}

std::array<JointArray, kJointCount> jointOfMotor(const VirtualRavenConfig& robot, Arm arm) {
  const Eigen::Matrix<double, 7, 7> inverse = raven::CableCoupling(arm, robot).inverse();
  std::array<JointArray, kJointCount> rows{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (std::size_t motor = 0; motor < kJointCount; ++motor)
      rows[j][motor] = inverse(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(motor));
  }
  return rows;
}

session::ControlGains logGains(const std::array<JointGains, kJointCount>& all) {
  session::ControlGains gains;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    gains.kp[j] = all[j].kp;
    gains.kd[j] = all[j].kd;
    gains.ki[j] = all[j].ki;
  }
  return gains;
}

session::TickConstants tickConstants(const TrainerConfig& config) {
  session::TickConstants constants;
  constants.d4 = config.arms.geometry.d4;
  constants.lw = config.arms.geometry.lw;
  for (const Arm arm : kArms) {
    at(constants.joint_of_motor, arm) = jointOfMotor(config.virtual_raven, arm);
    at(constants.gains, arm) = logGains(control::gainsOf(config.model, arm));
  }
  return constants;
}

}  // namespace

session::LogHeader logHeader(const TrainerConfig& config,
                             const std::vector<std::string>& body_names,
                             const std::string& motion,
                             const session::SessionPaths& paths) {
  session::LogHeader header;
  header.seed = config.seed;
  for (const Scenario& scenario : config.scenarios)
    header.scenarios.push_back(scenario.name);
  header.hazard = config.hazard;
  header.robot_urdf_hash = session::fileHash(config.robot_urdf);
  header.scene_urdf_hash = session::fileHash(config.scene_urdf);
  header.config_hash = combinedHash(config);
  describeTraining(config, &header);
  header.motion = motion;
  header.d4 = config.arms.geometry.d4;
  header.tolerance = config.haptics.tolerance;
  header.model_version = kModelVersion;
  header.arm_contacts = config.model.arm_contacts;
  header.body_names = body_names;
  header.configuration =
      session::copyConfiguration(paths, configurationFiles(config), config.overridden, placesOf(config));
  return header;
}

Recorder::Recorder(const TrainerConfig& config,
                   const std::vector<std::string>& body_names,
                   const session::SessionPaths& paths,
                   const std::string& motion,
                   SharedState* shared,
                   session::FlightRecorder* flight)
    : shared_(*shared),
      paths_(paths),
      header_(logHeader(config, body_names, motion, paths)),
      log_(paths.log(), header_, tickConstants(config)),
      flight_(flight),
      metrics_(header_) {
  order_.reserve(kMostParts);
  shared_.records.forEach(
      [this](RecordKind kind, const auto& ring) { written_.tails[static_cast<std::size_t>(kind)] = ring.head(); });
  collected_ = written_;
  if (flight_ == nullptr) return;
  flight_->attach(paths);
  flight_->checkpoint({log_.position(), written_.tails, {}});
}

void Recorder::takeMemory() {
  log_.reserve(sizeof(RecordRings) * 5 / 4);  // full queues; the frames around short records take more than a slot's
}

/** Adds what is new in the queues to the log's batch. */
void Recorder::collect() {
  const RecordTally dropped = shared_.records.dropped();  // first: these are missing behind what is in the queues
  // The loops push what a tick consumed before the tick: with the ticks' end taken first, all of it comes before them.
  const std::uint64_t last_tick = shared_.tick_records.tail();
  shared_.records.forEach([&](RecordKind kind, const auto& ring) {
    const std::uint64_t tail = kind == RecordKind::kTick ? last_tick : ring.tail();
    std::uint64_t& taken = collected_.tails[static_cast<std::size_t>(kind)];
    for (; taken < tail; ++taken) {
      log_.write(ring.at(taken));
      if constexpr (std::is_same_v<std::decay_t<decltype(ring.at(0))>, TickRecord>)
        collected_.tick = ring.at(taken).model.tick;
    }
  });
  writeGap(refused_since_gap_ != 0 ? GapReason::kNotWritten : GapReason::kQueueFull, minus(dropped, collected_.dropped),
           collected_.tick);
  collected_.dropped = dropped;
  order_.push_back(collected_.tails);
}

/** Whether the batch is long enough, or one of the queues needs its room. */
bool Recorder::isDue() const {
  bool is_due = collected_.tick - written_.tick >= kBatch || order_.size() >= kMostParts;
  shared_.records.forEach([&](RecordKind kind, const auto& ring) {
    const std::uint64_t waiting = collected_.tails[static_cast<std::size_t>(kind)] - ring.head();
    is_due = is_due || waiting * kLargestShare >= std::decay_t<decltype(ring)>::kCapacity;
  });
  return is_due;
}

void Recorder::writeGap(GapReason reason, const RecordTally& lost, Tick tick) {
  if (tallyTotal(lost) != 0) log_.write(GapRecord{tick, reason, refused_since_gap_, lost});
}

/** The batch is in the log: says so to the flight recorder, feeds the metrics, gives back the queues' room. */
void Recorder::settle() {
  if (collected_.dropped != written_.dropped) refused_since_gap_ = 0;
  written_ = collected_;
  if (flight_ != nullptr) flight_->checkpoint({log_.position(), written_.tails, written_.dropped});
  for (const RecordTally& tails : order_)
    release(tails);
  order_.clear();
  // The disk takes records again, and the trouble cost none.
  if (shared_.records.dropped() == written_.dropped) refused_since_gap_ = 0;
}

void Recorder::release(const RecordTally& tails) {
  shared_.records.forEach([&](RecordKind kind, auto& ring) {
    const std::uint64_t tail = tails[static_cast<std::size_t>(kind)];
    for (std::uint64_t i = ring.head(); i < tail; ++i) {
      if constexpr (CountsForMetrics<std::decay_t<decltype(ring.at(0))>>::value) metrics_.add(ring.at(i));
    }
    ring.release(tail);
  });
}

bool Recorder::write() {
  if (log_.commit()) {
    settle();
    return true;
  }
  refused_since_gap_ = log_.error();
  collected_ = written_;  // the log has dropped its batch; the queues still have it
  order_.clear();
  return false;
}

bool Recorder::tryDrain(bool at_once) {
  collect();
  return (!at_once && !isDue()) || write();
}

void Recorder::drain() {
  if (!tryDrain(/*at_once=*/true)) refuse();
}

void Recorder::follow() {
  if (!tryDrain(/*at_once=*/false)) refuse();
}

void Recorder::refuse() const {
  throw SessionException(paths_.log() + ": cannot be written: " + std::strerror(log_.error()));
}

void Recorder::drain(std::int64_t now_ns, bool at_once) {
  if (now_ns < retry_ns_) return;
  const bool survives = flight_ != nullptr && flight_->outlives();
  const std::uint64_t before = log_.position().size;
  const bool taken = tryDrain(at_once || !survives || status_.failing != 0);
  if (!taken) {
    reportRefusal();
    retry_ns_ = now_ns + kRetryNs;
  } else if (status_.failing != 0) {
    reportReturn();
  }
  // Right behind a batch. Between two the next one would wait for its sync.
  if (log_.position().size > before && now_ns - sync_ns_ >= kSyncNs) {
    if (!log_.sync()) status_.error = log_.error();
    sync_ns_ = now_ns;
  }
  status_.lost = tallyTotal(shared_.records.dropped());
  shared_.recorder.store(status_);
}

void Recorder::reportRefusal() {
  status_.error = log_.error();
  if (status_.failing == 0) {
    std::fprintf(stderr, "%s: cannot be written: %s; the session goes on, its record is tried again\n",
                 paths_.log().c_str(), std::strerror(log_.error()));
  }
  status_.failing = 1;
}

void Recorder::reportReturn() {
  status_.failing = 0;
  retry_ns_ = 0;
  std::fprintf(stderr, "%s: written again; %llu records of this session are missing in it\n", paths_.log().c_str(),
               static_cast<unsigned long long>(tallyTotal(written_.dropped)));
}

/** Footer, and before it what is left, or a gap record in its place. */
void Recorder::writeEnd(SessionCounts* counts) {
  if (!tryDrain(/*at_once=*/true)) giveUp(counts);
  log_.finish(*counts);
}

/** Records that the disk does not take are lost: they count as never queued. */
void Recorder::giveUp(SessionCounts* counts) {
  RecordTally lost = minus(shared_.records.dropped(), written_.dropped);
  shared_.records.forEach([&](RecordKind kind, const auto& ring) {
    const std::uint64_t waiting = ring.tail() - ring.head();
    lost[static_cast<std::size_t>(kind)] += waiting;
    RingCounts& ring_counts = counts->rings[static_cast<std::size_t>(ringOf(kind))];
    ring_counts.pushed -= std::min(waiting, ring_counts.pushed);
    ring_counts.dropped += waiting;
  });
  writeGap(GapReason::kNotWritten, lost, written_.tick);
  counts->records_dropped = tallyTotal(written_.dropped) + tallyTotal(lost);
}

void Recorder::finish(SessionCounts counts) {
  try {
    writeEnd(&counts);
  } catch (const SessionException&) {
    if (flight_ != nullptr) flight_->keep();
    throw;
  }
  if (flight_ != nullptr) flight_->remove();
  metrics_.add(counts);
  const training::SessionMetrics metrics = metrics_.result();
  training::writeMetrics(paths_.metrics(), metrics);
  training::writeFaults(paths_.faults(), metrics);
}

}  // namespace raven2_trainer::recording
