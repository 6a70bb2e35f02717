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
  std::string ticks() const { return directory + "/ticks.csv"; }
  std::string flight() const { return directory + "/flight_recorder"; }  ///< a link, until the log ends cleanly
  std::string recovered() const { return directory + "/recovered.json"; }
};

/**
 * Creates the directory, or `sessions/<UTC stamp>` below the working directory if `output` is empty.
 * @throw SessionException if it cannot be created, or already contains a session.
 */
SessionPaths createSessionDirectory(const std::string& output);

/** Paths of an existing session; recovers an unclean session first (recoverSession). @throw SessionException if the
 * directory has no session.rlog. */
SessionPaths openSessionDirectory(const std::string& directory);

/** Contents of meta.json, the session's only file with wall-clock values. */
struct SessionMeta {
  std::string program;  ///< simulator or simulate
  std::string version;
  std::string start_time_utc;
  double wall_duration{};  ///< [s]
  std::string realtime;    ///< granted scheduling, as text; "lockstep"
  std::string motion;
  std::map<std::string, std::string> build{};     ///< recording::buildIdentity()
  std::string ingest{};                           ///< accepted ITP formats and senders, as text; empty in lockstep
  std::string usb_truth{};                        ///< value of RAVEN2_USB_FAULTS_TRUTH; empty: not set
  std::string flight_recorder{"none: lockstep"};  ///< FlightRecorder::description()
};

/** Writes meta.json: `meta`, seed, hazard, and the name and FNV-1a hash of every configuration file as it was read.
 * "overridden" marks files with overridden values. */
void writeMeta(const SessionPaths& paths, const SessionMeta& meta, const ConfigSource& config);

/** SessionMeta::build of a session; empty if meta.json is missing, unreadable or without it. */
std::map<std::string, std::string> readBuild(const SessionPaths& paths);

/** SessionMeta::usb_truth of a session; empty if meta.json is missing or unreadable. */
std::string readUsbTruthFile(const SessionPaths& paths);

/** Path and hash of each of a session's configuration files and of both URDFs, from meta.json. */
std::vector<std::pair<std::string, std::string>> readConfigurationFiles(const SessionPaths& paths);

/** SessionMeta::start_time_utc of a session; empty if meta.json is missing or unreadable. */
std::string readStartTime(const SessionPaths& paths);

/** 64-bit FNV-1a hash of a file, as 16 hex digits. @throw SessionException if it cannot be read. */
std::string fileHash(const std::string& path);

/** The same hash of a text. */
std::string textHash(const std::string& text);

/** The same hash of a configuration file as it was read, with its overridden values. */
std::string readHash(const ConfigSource& config, const std::string& path);

}  // namespace raven2_trainer::session
