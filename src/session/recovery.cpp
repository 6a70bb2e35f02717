#include "raven2_trainer/session/recovery.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "flight_file.h"
#include "log_scanner.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kTail = 8 * 1024;  // [bytes] longer than the longest last record, the counters with 1.3 KiB

std::vector<std::uint8_t> tailOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::streamoff>(file.tellg());
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::clamp<std::streamoff>(size, 0, kTail)));
  file.seekg(size - static_cast<std::streamoff>(bytes.size()));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file ? bytes : std::vector<std::uint8_t>{};
}

/** Whether an intact record of kind `type` ends exactly where the bytes end. */
bool endsWith(const std::vector<std::uint8_t>& bytes, RecordType type) {
  for (std::size_t start = 0; start + kFrameHeaderSize + kCrcSize <= bytes.size(); ++start) {
    const FrameHeader header = decodeFrameHeader(bytes.data() + start);
    if (header.magic != kMagic || header.type != type) continue;
    const std::size_t body = kFrameHeaderSize + header.length;
    if (start + body + kCrcSize != bytes.size()) continue;
    std::uint32_t crc = 0;
    std::memcpy(&crc, bytes.data() + start + body, kCrcSize);
    if (crc == crc32Of(bytes.data() + start, body)) return true;
  }
  return false;
}

bool isRecovered(const std::string& log) {
  return endsWith(tailOf(log), RecordType::kRecovery);
}

bool hasEnd(const std::string& log) {
  return isRecovered(log) || endsWith(tailOf(log), RecordType::kCounts);
}

/** Whether no living process writes the log. The lock is given back: the writer of the recovery takes its own. */
bool isAbandoned(const std::string& log) {
  const int fd = ::open(log.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return true;
  const bool free = ::flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  ::close(fd);
  return free;
}

struct Cancelled {};

/** Where the last intact record of the log ends; nothing if there is no intact header. @throw Cancelled. */
std::optional<LogPosition> intactEnd(const std::string& log, const std::function<bool()>& cancelled) {
  constexpr std::uint64_t kAskEvery = 1024;  // [records] 0.3 s of a session
  LogScanner scanner(log);
  LogPosition end;
  FrameHeader header;
  const std::uint8_t* payload = nullptr;
  while (scanner.next(&header, &payload)) {
    if (end.size == 0 && (header.type != RecordType::kHeader || scanner.badBytes() != 0)) return std::nullopt;
    end = {scanner.position(), header.number + 1};
    if (end.next_number % kAskEvery == 0 && cancelled && cancelled()) throw Cancelled{};
  }
  if (end.size == 0) return std::nullopt;
  return end;
}

/** Moves what a queue holds beyond the checkpoint to the log. */
class QueueMover {
 public:
  QueueMover(const FlightCheckpoint& checkpoint, LogWriter* log, Recovery* result)
      : checkpoint_(checkpoint), log_(*log), result_(*result) {}

  template <typename Ring>
  void operator()(RecordKind kind, const Ring& ring) {
    const auto k = static_cast<std::size_t>(kind);
    const std::uint64_t head = checkpoint_.heads[k];
    const std::uint64_t waiting = ring.tail() - head;
    if (waiting > Ring::kCapacity) return;  // the queue's own numbers are damaged: its elements cannot be found
    if constexpr (std::is_same_v<typename Ring::Element, TickRecord>)
      if (head > 0 && ring.isIntact(head - 1)) newest_tick_ = ring.at(head - 1).model.tick;  // the log's last one
    for (std::uint64_t i = head; i < head + waiting; ++i) {
      if (ring.isIntact(i)) {
        log_.write(ring.at(i));
        ++result_.recovered[k];
        if constexpr (std::is_same_v<typename Ring::Element, TickRecord>) newest_tick_ = ring.at(i).model.tick;
      } else {
        ++damaged_[k];
      }
    }
    dropped_[k] = ring.dropped() - checkpoint_.dropped[k];
  }

  void writeGaps() {
    writeGap(GapReason::kQueueFull, dropped_);
    writeGap(GapReason::kDamaged, damaged_);
  }

 private:
  void writeGap(GapReason reason, const RecordTally& lost) {
    if (tallyTotal(lost) == 0) return;
    log_.write(GapRecord{newest_tick_, reason, 0, lost});
    for (std::size_t k = 0; k < kRecordKindCount; ++k)
      result_.lost[k] += lost[k];
  }

  const FlightCheckpoint& checkpoint_;
  LogWriter& log_;
  Recovery& result_;
  RecordTally dropped_{}, damaged_{};
  Tick newest_tick_{-1};
};

Json describeTally(const RecordTally& tally) {
  Json json;
  for (std::size_t k = 0; k < kRecordKindCount; ++k)
    json[kRecordKindNames[k]] = tally[k];
  return json;
}

void writeNote(const SessionPaths& paths, const Recovery& result) {
  const Json json{{"ended", "unclean"},
                  {"log", result.status == RecoveryStatus::kNoLog ? "killed before its first record" : "complete"},
                  {"flight_recorder", result.flight_recorder},
                  {"records_recovered", describeTally(result.recovered)},
                  {"records_lost", describeTally(result.lost)},
                  {"cut_bytes", result.cut_bytes}};
  std::ofstream file(paths.recovered());
  file << json.dump(2) << '\n';
}

/** Only what is surely ours: the file was read as the flight recorder of this very log. */
void removeFlightFile(const SessionPaths& paths) {
  std::error_code error;
  const fs::path file = fs::read_symlink(paths.flight(), error);
  if (!error) fs::remove(file, error);
  fs::remove(paths.flight(), error);
}

void complete(const SessionPaths& paths, const FlightFile* flight, const LogPosition& end, Recovery* result) {
  LogWriter log(paths.log(), end);
  if (flight != nullptr) {
    QueueMover mover(newestCheckpoint(*flight)->checkpoint, &log, result);
    flight->rings.forEach(mover);
    mover.writeGaps();
  }
  log.finishRecovery(RecoveryRecord{result->recovered, result->cut_bytes});
}

/** Where the log is to go on. With a flight recorder at its checkpoint, if the log still reaches that far. */
std::optional<LogPosition> goOnAt(const SessionPaths& paths,
                                  const FlightFile* flight,
                                  const std::function<bool()>& cancelled) {
  const std::uint64_t size = fs::file_size(paths.log());
  if (flight != nullptr) {
    const LogPosition& position = newestCheckpoint(*flight)->checkpoint.log;
    if (position.size <= size) return position;
  }
  return intactEnd(paths.log(), cancelled);
}

}  // namespace

bool isUnclean(const SessionPaths& paths) {
  std::error_code error;
  if (!fs::is_regular_file(paths.log(), error) || fs::exists(paths.recovered(), error)) return false;
  return !endsWith(tailOf(paths.log()), RecordType::kCounts);
}

bool isBeingWritten(const SessionPaths& paths) {
  return isUnclean(paths) && !isAbandoned(paths.log());
}

bool lacksMetrics(const SessionPaths& paths) {
  std::error_code error;
  return fs::is_regular_file(paths.log(), error) && !fs::exists(paths.metrics(), error) && hasEnd(paths.log()) &&
         isAbandoned(paths.log());  // else its writer is about to write them
}

bool leavesFlightFile(const SessionPaths& paths) {
  std::error_code error;
  return fs::exists(paths.flight(), error) && !isUnclean(paths);
}

Recovery recoverSession(const SessionPaths& paths, const std::function<bool()>& cancelled) try {
  Recovery result;
  if (leavesFlightFile(paths) && isAbandoned(paths.log())) {
    std::string reason;
    if (readFlightFile(paths, &reason)) removeFlightFile(paths);
  }
  if (!isUnclean(paths)) return result;
  if (!isAbandoned(paths.log())) {
    result.status = RecoveryStatus::kRunning;
    return result;
  }
  std::string reason;
  const std::unique_ptr<FlightFile> flight = readFlightFile(paths, &reason);
  result.flight_recorder = flight ? "used" : reason;
  // A recovery that was killed behind the log's last record: with the flight recorder it is done again, from the same
  // place.
  const bool is_done = flight == nullptr && isRecovered(paths.log());
  const std::optional<LogPosition> end = goOnAt(paths, flight.get(), cancelled);
  result.status = end ? RecoveryStatus::kRecovered : RecoveryStatus::kNoLog;
  if (end && !is_done) {
    if (::access(paths.log().c_str(), W_OK) != 0) {
      result.status = RecoveryStatus::kNotWritable;
      return result;
    }
    result.cut_bytes = fs::file_size(paths.log()) - end->size;
    complete(paths, flight.get(), *end, &result);
  }
  writeNote(paths, result);
  if (flight) removeFlightFile(paths);
  return result;
} catch (const Cancelled&) {
  Recovery result;
  result.status = RecoveryStatus::kCancelled;
  return result;
}

std::vector<std::string> findUnfinishedSessions(const std::string& parent, std::size_t limit) {
  std::vector<std::pair<fs::file_time_type, std::string>> sessions;
  std::error_code error;
  for (fs::directory_iterator entry(parent, error), end; !error && entry != end; entry.increment(error)) {
    const SessionPaths paths{entry->path().string()};
    std::error_code none;
    const auto written = fs::last_write_time(paths.log(), none);
    const bool is_unfinished = isUnclean(paths) || lacksMetrics(paths) || leavesFlightFile(paths);
    if (!none && is_unfinished && isAbandoned(paths.log())) sessions.emplace_back(written, paths.directory);
  }
  std::sort(sessions.rbegin(), sessions.rend());
  if (sessions.size() > limit) sessions.resize(limit);
  std::vector<std::string> directories;
  for (const auto& session : sessions)
    directories.push_back(session.second);
  return directories;
}

}  // namespace raven2_trainer::session
