#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/raven/raven_report.h"

namespace raven2_trainer::studies {

/** One datagram of a recorded ITP stream. */
struct TraceDatagram {
  double t_s{};                     ///< [s] when it was sent, on the recording's clock
  std::vector<std::uint8_t> bytes;  ///< as on the wire; any size
};

/**
 * Reads recorded datagrams: CSV, gzipped or not, with the columns t_s, sequence, delx0, delx1, dely0, dely1, delz0,
 * delz1, Qx0, Qx1, Qy0, Qy1, Qz0, Qz1, Qw0, Qw1, buttonstate0, buttonstate1, grasp0, grasp1, surgeon_mode, checksum,
 * size, pactyp, version in any order, units of the wire. `size` [bytes] other than 124 cuts the datagram or pads it
 * with zeros. Quaternions may be nan or inf.
 * @throw SessionException with FILE:LINE and the column for anything else.
 */
std::vector<TraceDatagram> readItpTrace(const std::string& path);

/** Header of a state recording, with its line end. */
std::string stateTraceHeader();

/** One row of a state recording, with its line end: the columns, units and number formats of a recorded /ravenstate
 *  (um; radians and metres both times 180/pi; mvel in whole deg/s; tau in Nm). */
std::string stateTraceRow(double t_s, const RavenReport& report);

struct ReplayOptions {
  bool skip_homing{false};   ///< begin at the exact home pose in PEDAL_UP
  double press_start{-1.0};  ///< [s] after an E-STOP the start button is pressed; negative: never
  double tail{1.0};          ///< [s] after the last datagram; with the pedal down, until the master's time-out too
};

struct ReplaySummary {
  std::uint64_t cycles{};
  double seconds{};  ///< [s] simulated
  LinkCounts itp{};  ///< as the robot counted
};

/**
 * Drives the emulated control software on the emulated plant with recorded datagrams, cycle by cycle, with no sockets
 * and no clock, and writes one row a cycle.
 *
 * Alignment: the cycles run at t0 + k ms, t0 being the t_s of the first datagram; a datagram is received before the
 * cycle nearest to its t_s, after all that precede it in the file. Cycle 0 is the first after the one that reported
 * PEDAL_UP (with `skip_homing`: the first). A row's t_s is its cycle's time + kPublishDelay.
 */
class Replay {
 public:
  /** [s] from a datagram's t_s to the row that shows it in recordings of the real software (median over 15 s). */
  static constexpr double kPublishDelay = 0.00087;

  /** @throw ConfigException, ModelException. */
  Replay(const TrainerConfig& config, const ReplayOptions& options);
  ~Replay();

  /** @param[in] row called with every row of the recording, header first.
   *  @param[in] progress called now and then with 0..1; may be empty.
   *  @throw SessionException if PEDAL_UP is not reached in 60 s. */
  ReplaySummary run(const std::vector<TraceDatagram>& trace,
                    const std::function<void(const std::string&)>& row,
                    const std::function<void(double)>& progress);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Reads `input`, replays, writes `output` (gzipped if its name ends in .gz). @throw as the above. */
ReplaySummary replayFile(const TrainerConfig& config,
                         const ReplayOptions& options,
                         const std::string& input,
                         const std::string& output,
                         const std::function<void(double)>& progress);

}  // namespace raven2_trainer::studies
