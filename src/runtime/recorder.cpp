#include "raven2_trainer/runtime/recorder.h"

namespace raven2_trainer::runtime {
namespace {

std::string combinedHash(const std::vector<std::string>& files) {
  std::string hashes;
  for (const std::string& file : files)
    hashes += session::fileHash(file);
  return hashes;
}

}  // namespace

std::uint64_t recordsDropped(const SharedState& shared) noexcept {
  return shared.tick_records.dropped() + shared.haptic_records.dropped() + shared.command_records.dropped() +
         shared.request_records.dropped() + shared.plan_records.dropped() + shared.contact_records.dropped();
}

session::LogHeader logHeader(const TrainerConfig& config,
                             const std::vector<std::string>& body_names,
                             const std::string& motion) {
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
  return header;
}

Recorder::Recorder(const TrainerConfig& config,
                   const std::vector<std::string>& body_names,
                   const session::SessionPaths& paths,
                   const std::string& motion,
                   SharedState* shared)
    : shared_(*shared),
      paths_(paths),
      header_(logHeader(config, body_names, motion)),
      log_(paths.log(), header_),
      metrics_(header_) {}

template <typename Record, std::size_t Capacity>
void Recorder::drainRing(SpscRing<Record, Capacity>* ring) {
  Record record;
  while (ring->tryPop(&record)) {
    log_.write(record);
    if constexpr (std::is_same_v<Record, TickRecord>) session_tick_ = record.model.session_tick;
    if constexpr (std::is_same_v<Record, TickRecord> || std::is_same_v<Record, HapticRecord> ||
                  std::is_same_v<Record, PlanRecord>) {
      metrics_.add(record);
    }
  }
}

void Recorder::drain() {
  drainRing(&shared_.command_records);
  drainRing(&shared_.request_records);
  drainRing(&shared_.plan_records);
  drainRing(&shared_.contact_records);
  drainRing(&shared_.tick_records);
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
