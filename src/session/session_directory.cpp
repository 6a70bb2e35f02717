#include "raven2_trainer/session/session_directory.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/recovery.h"

namespace raven2_trainer::session {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/** 2026-01-31T12-00-00Z: sorts by time, and no colon, which some file systems refuse. */
std::string utcStamp() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H-%M-%SZ", &utc);
  return text.data();
}

/** Two sessions started in the same second get -2, -3 ... */
std::string unusedStampedDirectory() {
  const std::string stamped = "sessions/" + utcStamp();
  std::string name = stamped;
  for (int n = 2; fs::exists(name); ++n)
    name = stamped + "-" + std::to_string(n);
  return name;
}

Json describeFile(const ConfigSource& config, const std::string& path) {
  return {{"name", fs::path(path).filename().string()}, {"path", path}, {"fnv1a", readHash(config, path)}};
}

Json describeFiles(const ConfigSource& config) {
  Json files = Json::array();
  for (const std::string& path : config.files) {
    files.push_back(describeFile(config, path));
    if (config.overridden.count(path) > 0) files.back()["overridden"] = true;
  }
  return files;
}

// FNV-1a, 64 bit (RFC 9923): offset basis and prime.
constexpr std::uint64_t kHashBasis = 0xcbf29ce484222325ULL;
constexpr std::uint64_t kHashPrime = 0x100000001b3ULL;

std::uint64_t extended(std::uint64_t hash, const char* bytes, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i)
    hash = (hash ^ static_cast<unsigned char>(bytes[i])) * kHashPrime;
  return hash;
}

std::string hexadecimal(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

}  // namespace

SessionPaths createSessionDirectory(const std::string& output) {
  std::error_code error;
  const SessionPaths paths{output.empty() ? unusedStampedDirectory() : output};
  fs::create_directories(paths.directory, error);
  if (error || !fs::is_directory(paths.directory)) {
    throw SessionException(paths.directory + ": cannot be created: " + (error ? error.message() : "not a directory"));
  }
  if (fs::exists(paths.log())) {
    throw SessionException(paths.directory + ": already holds a session (session.rlog); give another directory");
  }
  return paths;
}

SessionPaths openSessionDirectory(const std::string& directory) {
  SessionPaths paths{directory};
  std::error_code error;
  if (!fs::is_regular_file(paths.log(), error)) {
    throw SessionException(directory + ": is no session directory (no session.rlog in it)");
  }
  try {
    recoverSession(paths);
  } catch (const SessionException&) {
    // Read as it is, then; what cannot be read says so when it is.
  }
  return paths;
}

void writeMeta(const SessionPaths& paths, const SessionMeta& meta, const ConfigSource& config) {
  Json json{{"program", meta.program},
            {"version", meta.version},
            {"start_time_utc", meta.start_time_utc},
            {"wall_duration_s", meta.wall_duration},
            {"flight_recorder", meta.flight_recorder},
            {"realtime", meta.realtime},
            {"motion", meta.motion},
            {"ingest", meta.ingest},
            {"seed", config.seed},
            {"hazard", config.hazard},
            {"build", meta.build},
            {"config_files", describeFiles(config)}};
  if (!meta.usb_truth.empty()) json["usb_faults_truth"] = meta.usb_truth;
  if (!config.robot_urdf.empty()) json["robot_urdf"] = describeFile(config, config.robot_urdf);
  if (!config.scene_urdf.empty()) json["scene_urdf"] = describeFile(config, config.scene_urdf);
  const std::string draft = paths.meta() + ".part";  // renamed: on a full disk the one from the start stays
  std::ofstream file(draft);
  file << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  file.close();
  if (!file || std::rename(draft.c_str(), paths.meta().c_str()) != 0)
    throw SessionException(paths.meta() + ": cannot be written");
}

std::map<std::string, std::string> readBuild(const SessionPaths& paths) {
  std::ifstream file(paths.meta());
  const Json json = Json::parse(file, nullptr, /*allow_exceptions=*/false);
  std::map<std::string, std::string> build;
  if (!json.is_object() || !json.contains("build") || !json["build"].is_object()) return build;
  for (const auto& [name, value] : json["build"].items()) {
    if (value.is_string()) build[name] = value;
  }
  return build;
}

namespace {

/** A text of meta.json; empty if it is missing. */
std::string readText(const SessionPaths& paths, const char* key) {
  std::ifstream file(paths.meta());
  const Json json = Json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return "";
  return json[key];
}

}  // namespace

std::vector<std::pair<std::string, std::string>> readConfigurationFiles(const SessionPaths& paths) {
  std::ifstream file(paths.meta());
  const Json json = Json::parse(file, nullptr, /*allow_exceptions=*/false);
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&](const Json& entry) {
    if (entry.is_object() && entry.contains("path") && entry.contains("fnv1a") && entry["path"].is_string() &&
        entry["fnv1a"].is_string())
      files.emplace_back(entry["path"], entry["fnv1a"]);
  };
  if (!json.is_object()) return files;
  for (const Json& entry : json.value("config_files", Json::array()))
    add(entry);
  for (const char* key : {"robot_urdf", "scene_urdf"})
    add(json.value(key, Json()));
  return files;
}

std::string readStartTime(const SessionPaths& paths) {
  return readText(paths, "start_time_utc");
}

std::string readUsbTruthFile(const SessionPaths& paths) {
  return readText(paths, "usb_faults_truth");
}

std::string fileHash(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw SessionException(path + ": cannot be read for its hash");
  std::uint64_t hash = kHashBasis;
  std::array<char, 65536> bytes;
  std::size_t got = 0;
  while ((got = std::fread(bytes.data(), 1, bytes.size(), file.get())) > 0)
    hash = extended(hash, bytes.data(), got);
  if (std::ferror(file.get()) != 0) throw SessionException(path + ": cannot be read for its hash");
  return hexadecimal(hash);
}

std::string textHash(const std::string& text) {
  return hexadecimal(extended(kHashBasis, text.data(), text.size()));
}

std::string readHash(const ConfigSource& config, const std::string& path) {
  const auto found = config.overridden.find(path);
  return found == config.overridden.end() ? fileHash(path) : textHash(found->second);
}

}  // namespace raven2_trainer::session
