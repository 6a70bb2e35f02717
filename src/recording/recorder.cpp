#include "raven2_trainer/recording/recorder.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/session/configuration_copy.h"

namespace raven2_trainer::recording {
namespace {

constexpr std::int64_t kRetryNs = 500'000'000;   // [ns] a quarter of the 2 s that the queues hold
constexpr std::int64_t kSyncNs = 1'000'000'000;  // [ns] what a loss of power can cost

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
  for (const auto& plant : std::filesystem::directory_iterator(config.virtual_raven.plants_folder, none))
    files.push_back(plant.path().string());  // the packaged files name one, whichever was chosen
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

/** The camera that the metric out_of_view asks for (config/render.yaml: the first). */
session::HeaderCamera scoredCamera(const RenderConfig& render) {
  if (render.cameras.empty()) return {};
  const CameraConfig& first = render.cameras.front();
  return {first.name, first.vertical_fov, 1.0 * render.video_width / render.video_height};
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
      log_(paths.log(), header_),
      flight_(flight),
      metrics_(header_) {
  if (flight_ == nullptr) return;
  flight_->attach(paths);
  flight_->checkpoint({log_.position(), {}, {}});
}

void Recorder::takeMemory() {
  log_.reserve(sizeof(RecordRings) * 5 / 4);  // full queues; the frames around short records take more than a slot's
}

/** Adds what is waiting to the log's batch. */
Recorder::Batch Recorder::collect() {
  Batch batch;
  batch.tick = tick_;
  batch.dropped = shared_.records.dropped();  // first: these are missing behind what is in the queues, not before
  // The loops push what a tick consumed before the tick: with the ticks' end taken first, all of it comes before them.
  const std::uint64_t last_tick = shared_.tick_records.tail();
  shared_.records.forEach([&](RecordKind kind, const auto& ring) {
    const std::uint64_t tail = kind == RecordKind::kTick ? last_tick : ring.tail();
    for (std::uint64_t i = ring.head(); i < tail; ++i) {
      log_.write(ring.at(i));
      if constexpr (std::is_same_v<std::decay_t<decltype(ring.at(i))>, TickRecord>) batch.tick = ring.at(i).model.tick;
    }
    batch.tails[static_cast<std::size_t>(kind)] = tail;
  });
  writeGap(refused_since_gap_ != 0 ? GapReason::kNotWritten : GapReason::kQueueFull, minus(batch.dropped, reported_),
           batch.tick);
  return batch;
}

void Recorder::writeGap(GapReason reason, const RecordTally& lost, Tick tick) {
  if (tallyTotal(lost) != 0) log_.write(GapRecord{tick, reason, refused_since_gap_, lost});
}

/** The batch is in the log: says so to the flight recorder, feeds the metrics, gives back the queues' room. */
void Recorder::settle(const Batch& batch) {
  if (batch.dropped != reported_) refused_since_gap_ = 0;
  reported_ = batch.dropped;
  tick_ = batch.tick;
  if (flight_ != nullptr) flight_->checkpoint({log_.position(), batch.tails, reported_});
  release(batch.tails);
  // The disk takes records again, and the trouble cost none.
  if (shared_.records.dropped() == reported_) refused_since_gap_ = 0;
}

void Recorder::release(const RecordTally& tails) {
  shared_.records.forEach([&](RecordKind kind, auto& ring) {
    using Record = std::decay_t<decltype(ring.at(0))>;
    const std::uint64_t tail = tails[static_cast<std::size_t>(kind)];
    for (std::uint64_t i = ring.head(); i < tail; ++i) {
      if constexpr (std::is_same_v<Record, TickRecord>) session_tick_ = ring.at(i).model.session_tick;
      if constexpr (CountsForMetrics<Record>::value) metrics_.add(ring.at(i));
    }
    ring.release(tail);
  });
}

bool Recorder::tryDrain() {
  const Batch batch = collect();
  if (!log_.commit()) {
    refused_since_gap_ = log_.error();
    return false;
  }
  settle(batch);
  return true;
}

void Recorder::drain() {
  if (!tryDrain()) throw SessionException(paths_.log() + ": cannot be written: " + std::strerror(log_.error()));
}

void Recorder::drain(std::int64_t now_ns) {
  if (now_ns < retry_ns_) return;
  const bool taken = tryDrain();
  if (!taken) {
    reportRefusal();
    retry_ns_ = now_ns + kRetryNs;
  } else if (status_.failing != 0) {
    reportReturn();
  }
  if (taken && now_ns - sync_ns_ >= kSyncNs) {
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
               static_cast<unsigned long long>(tallyTotal(reported_)));
}

/** Footer, and before it what is left, or a gap record in its place. */
void Recorder::writeEnd(SessionCounts* counts) {
  if (!tryDrain()) giveUp(counts);
  log_.finish(*counts);
}

/** Records that the disk does not take are lost: they count as never queued. */
void Recorder::giveUp(SessionCounts* counts) {
  RecordTally lost = minus(shared_.records.dropped(), reported_);
  shared_.records.forEach([&](RecordKind kind, const auto& ring) {
    const std::uint64_t waiting = ring.tail() - ring.head();
    lost[static_cast<std::size_t>(kind)] += waiting;
    RingCounts& ring_counts = counts->rings[static_cast<std::size_t>(ringOf(kind))];
    ring_counts.pushed -= std::min(waiting, ring_counts.pushed);
    ring_counts.dropped += waiting;
  });
  writeGap(GapReason::kNotWritten, lost, tick_);
  counts->records_dropped = tallyTotal(reported_) + tallyTotal(lost);
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
