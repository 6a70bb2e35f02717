#pragma once

#include <map>
#include <string>

#include "raven2_trainer/session/config_source.h"

namespace raven2_trainer::session {

/** Files of a session directory. */
struct SessionPaths {
  std::string directory;
  std::string log() const { return directory + "/session.rlog"; }
  std::string metrics() const { return directory + "/metrics.json"; }
  std::string meta() const { return directory + "/meta.json"; }
  std::string faults() const { return directory + "/faults.json"; }
  std::string usbTruth() const { return directory + "/usb_truth.json"; }  ///< training/usb_truth.h
  std::string score() const { return directory + "/score.json"; }
  std::string video() const { return directory + "/video.mp4"; }
  std::string report() const { return directory + "/report.html"; }
  std::string ticks() const { return directory + "/ticks.csv"; }
  std::string flight() const { return directory + "/flight_recorder"; }  ///< a link, while not ended cleanly
  std::string recovered() const { return directory + "/recovered.json"; }
};

/**
 * Creates the directory, or `sessions/<UTC stamp>` below the working directory if `output` is empty.
 * @throw SessionException if it cannot be created, or already holds a session.
 */
SessionPaths createSessionDirectory(const std::string& output);

/** Paths of an existing session; an unclean one is recovered first (recoverSession). @throw SessionException if there
 * is no session.rlog in it. */
SessionPaths openSessionDirectory(const std::string& directory);

/** What meta.json says; the only file of a session with wall-clock values. */
struct SessionMeta {
  std::string program;  ///< simulator or simulate
  std::string version;
  std::string start_time_utc;
  double wall_duration{};  ///< [s]
  std::string realtime;    ///< what scheduling was granted, in words; "lockstep"
  std::string motion;
  std::map<std::string, std::string> build{};     ///< what decides over the bits, apart from the inputs, by name
  std::string ingest{};                           ///< what was taken for ITP and from whom, in words; empty in lockstep
  std::string usb_truth{};                        ///< what RAVEN2_USB_FAULTS_TRUTH named; empty: it was not set
  std::string flight_recorder{"none: lockstep"};  ///< file of the record queues while the session runs, or "none: WHY"
};

/** Writes meta.json: the meta, seed, hazard, and name and FNV-1a hash of every configuration file, as it was read;
 * "overridden" where that is not as it stands. */
void writeMeta(const SessionPaths& paths, const SessionMeta& meta, const ConfigSource& config);

/** SessionMeta::build of a session; empty if there is no readable meta.json or nothing in it about the build. */
std::map<std::string, std::string> readBuild(const SessionPaths& paths);

/** SessionMeta::usb_truth of a session; empty if there is no readable meta.json. */
std::string readUsbTruthFile(const SessionPaths& paths);

/** Path and hash of each file that a session was configured by, and of both URDFs, as meta.json has them. */
std::vector<std::pair<std::string, std::string>> readConfigurationFiles(const SessionPaths& paths);

/** SessionMeta::start_time_utc of a session; empty if there is no readable meta.json. */
std::string readStartTime(const SessionPaths& paths);

/** FNV-1a, 64 bit, of a file, as 16 hex digits. @throw SessionException if it cannot be read. */
std::string fileHash(const std::string& path);

/** The same of a text. */
std::string textHash(const std::string& text);

/** The same of one of the configuration's files, as it was read: with what parameters override in it. */
std::string readHash(const ConfigSource& config, const std::string& path);

}  // namespace raven2_trainer::session
