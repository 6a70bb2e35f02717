#include "raven2_trainer/runtime/recorder.h"

#include <algorithm>
#include <filesystem>

#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/session/configuration_copy.h"

namespace raven2_trainer::runtime {
namespace {

std::string combinedHash(const std::vector<std::string>& files) {
  std::string hashes;
  for (const std::string& file : files)
    hashes += session::fileHash(file);
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
  header.config_hash = combinedHash(config.files);
  header.motion = motion;
  header.d4 = config.arms.geometry.d4;
  header.tolerance = config.haptics.tolerance;
  header.arm_contacts = config.model.arm_contacts;
  header.body_names = body_names;
  header.configuration = session::copyConfiguration(paths, configurationFiles(config));
  return header;
}

Recorder::Recorder(const TrainerConfig& config,
                   const std::vector<std::string>& body_names,
                   const session::SessionPaths& paths,
                   const std::string& motion,
                   SharedState* shared)
    : shared_(*shared),
      paths_(paths),
      header_(logHeader(config, body_names, motion, paths)),
      log_(paths.log(), header_),
      metrics_(header_) {}

template <typename Record>
void Recorder::write(const Record& record) {
  log_.write(record);
  if constexpr (std::is_same_v<Record, TickRecord>) session_tick_ = record.model.session_tick;
  if constexpr (std::is_same_v<Record, TickRecord> || std::is_same_v<Record, HapticRecord> ||
                std::is_same_v<Record, PlanRecord>) {
    metrics_.add(record);
  }
}

template <typename Record, std::size_t Capacity>
void Recorder::drainRing(SpscRing<Record, Capacity>* ring) {
  Record record;
  while (ring->tryPop(&record))
    write(record);
}

void Recorder::drainInputs() {
  drainRing(&shared_.fault_records);
  drainRing(&shared_.command_records);
  drainRing(&shared_.request_records);
  drainRing(&shared_.plan_records);
  drainRing(&shared_.contact_records);
}

/** What a tick consumed was pushed before it, so it stands before it in the log. */
void Recorder::drain() {
  TickRecord tick;
  while (shared_.tick_records.tryPop(&tick)) {
    drainInputs();
    write(tick);
  }
  drainInputs();
  drainRing(&shared_.haptic_records);
}

void Recorder::finish(const SessionCounts& counts) {
  drain();
  log_.finish(counts);
  metrics_.add(counts);
  const training::SessionMetrics metrics = metrics_.result();
  training::writeMetrics(paths_.metrics(), metrics);
  training::writeFaults(paths_.faults(), metrics);
}

}  // namespace raven2_trainer::runtime
