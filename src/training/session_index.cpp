#include "raven2_trainer/training/session_index.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <tuple>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::training {

namespace {

using Json = nlohmann::ordered_json;
constexpr int kIndexVersion = 1;
constexpr std::uintmax_t kMostIndexBytes = 64U << 20U;  // a thousand sessions are about 2 MB

/** Held while an index is read, changed and exchanged. */
class IndexLock {
 public:
  explicit IndexLock(const std::string& path) : file_(::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
    if (file_ < 0) throw SessionException(path + ": " + std::strerror(errno));
    int result = ::flock(file_, LOCK_EX);
    while (result != 0 && errno == EINTR)
      result = ::flock(file_, LOCK_EX);
    if (result == 0) return;
    const std::string why = std::strerror(errno);
    ::close(file_);
    throw SessionException(path + ": cannot be locked: " + why);
  }
  ~IndexLock() { ::close(file_); }
  IndexLock(const IndexLock&) = delete;
  IndexLock& operator=(const IndexLock&) = delete;

 private:
  int file_;
};

IndexAttempt readAttempt(const Json& json) {
  IndexAttempt attempt;
  attempt.status = json.at("status").get<std::string>();
  if (!json.at("passed").is_null()) attempt.passed = json.at("passed").get<bool>();
  for (const auto& [name, value] : json.at("metrics").items())
    attempt.metrics[name] = value.get<double>();
  return attempt;
}

IndexEntry readEntry(const Json& json) {
  IndexEntry entry;
  entry.directory = json.at("directory").get<std::string>();
  entry.start_time_utc = json.at("start_time_utc").get<std::string>();
  entry.trainee = json.at("trainee").get<std::string>();
  entry.exercise = json.at("exercise").get<std::string>();
  entry.drill = json.at("drill").get<std::string>();
  for (const Json& attempt : json.at("attempts"))
    entry.attempts.push_back(readAttempt(attempt));
  return entry;
}

Json describe(const IndexAttempt& attempt) {
  Json metrics = Json::object();
  for (const auto& [name, value] : attempt.metrics)
    metrics[name] = value;
  return {{"status", attempt.status},
          {"passed", attempt.passed ? Json(*attempt.passed) : Json(nullptr)},
          {"metrics", metrics}};
}

Json describe(const IndexEntry& entry) {
  Json attempts = Json::array();
  for (const IndexAttempt& attempt : entry.attempts)
    attempts.push_back(describe(attempt));
  return {{"directory", entry.directory}, {"start_time_utc", entry.start_time_utc},
          {"trainee", entry.trainee},     {"exercise", entry.exercise},
          {"drill", entry.drill},         {"attempts", attempts}};
}

Json parse(const std::string& path) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) > kMostIndexBytes) throw SessionException(path + ": larger than 64 MiB");
  std::ifstream file(path);
  if (!file) throw SessionException(path + ": cannot be read");
  return Json::parse(file);
}

void sort(std::vector<IndexEntry>* entries) {
  std::sort(entries->begin(), entries->end(), [](const IndexEntry& a, const IndexEntry& b) {
    return std::tie(a.start_time_utc, a.directory) < std::tie(b.start_time_utc, b.directory);
  });
}

void writeIndex(const std::string& path, const std::vector<IndexEntry>& entries) {
  Json sessions = Json::array();
  for (const IndexEntry& entry : entries)
    sessions.push_back(describe(entry));
  const std::string draft = path + ".part";
  std::ofstream file(draft);
  file << Json{{"version", kIndexVersion}, {"sessions", sessions}}.dump(1) << '\n';
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) throw SessionException(path + ": cannot be written");
}

}  // namespace

bool isTraineeId(const std::string& text) noexcept {
  return !text.empty() && text.size() <= 32 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::vector<IndexEntry> readIndex(const std::string& path) {
  std::vector<IndexEntry> entries;
  if (!std::filesystem::exists(path)) return entries;
  try {
    const Json json = parse(path);
    if (json.at("version").get<int>() != kIndexVersion) throw SessionException(path + ": not of version 1");
    for (const Json& entry : json.at("sessions"))
      entries.push_back(readEntry(entry));
  } catch (const Json::exception& e) {
    throw SessionException(path + ": not an index of sessions: " + e.what());
  }
  sort(&entries);
  return entries;
}

void addToIndex(const std::string& path, const IndexEntry& entry) {
  if (!isTraineeId(entry.trainee)) {
    throw SessionException("trainee \"" + entry.trainee.substr(0, 40) + "\": expected 1 to 32 of a-z, 0-9, _ and -");
  }
  const IndexLock lock(path + ".lock");
  std::vector<IndexEntry> entries = readIndex(path);
  const auto is_same = [&](const IndexEntry& other) { return other.directory == entry.directory; };
  entries.erase(std::remove_if(entries.begin(), entries.end(), is_same), entries.end());
  entries.push_back(entry);
  sort(&entries);
  writeIndex(path, entries);
}

std::vector<CurriculumAttempt> attemptsOf(const std::vector<IndexEntry>& index, const std::string& trainee) {
  std::vector<CurriculumAttempt> attempts;
  for (const IndexEntry& entry : index) {
    if (entry.trainee != trainee) continue;
    for (const IndexAttempt& attempt : entry.attempts)
      attempts.push_back({entry.exercise, entry.drill, attempt.passed});
  }
  return attempts;
}

}  // namespace raven2_trainer::training
