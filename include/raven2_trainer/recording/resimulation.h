#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::recording {

/** The first place where a session and its re-simulation part. */
struct Difference {
  Tick tick{};        ///< [1 ms] of the model
  std::string field;  ///< which, and both values
};

struct ResimulationResult {
  std::uint64_t ticks{};           ///< compared, up to the first difference
  std::uint64_t forces{};          ///< haptic ticks compared
  std::uint64_t forces_unknown{};  ///< haptic ticks whose inputs no tick record shows, so that nobody can compare them
  std::optional<Difference> difference;
};

/** The configuration a session was recorded with: the copies in its directory and what its log's header says.
 *  @throw SessionException naming the files that differ from the header's hashes; ConfigException. */
TrainerConfig sessionConfig(const session::SessionPaths& paths);

/**
 * Simulates a session again from its log: gives a PhysicsLoop, tick by tick, the inputs of the log
 * (commands, robot, requests, plans, faults, the time). Compares each ModelState and contact, bit for bit, with
 * those of the log, and each force with equations 5 and 6 on the states that its record names.
 * The same bits are promised for the same build of this package, of libode and of libm, on a processor with the same
 * instructions (buildIdentity()).
 */
class Resimulation {
 public:
  /**
   * @param[in] config sessionConfig(), or the one the session was run with.
   * @param[in] output directory of the session that the re-simulation records; empty: none.
   * @throw ModelException, SessionException.
   */
  Resimulation(const TrainerConfig& config, const session::SessionPaths& paths, const std::string& output);
  ~Resimulation();

  /**
   * Up to the first difference or the end of the log.
   * @param[in] progress called about every 100 ticks with the share of the log read; may be empty.
   * @throw SessionException if a tick is missing from the log, or an input comes after the tick that consumed it:
   * such a session cannot be simulated again.
   */
  ResimulationResult run(const std::function<void(double)>& progress);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::recording
