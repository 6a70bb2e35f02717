#include "flight_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "memory_layout.h"
#include "record_frame.h"

namespace raven2_trainer::session {

namespace {

using Json = nlohmann::ordered_json;

struct CloseFile {
  int fd;
  ~CloseFile() {
    if (fd >= 0) ::close(fd);
  }
};

std::uint64_t offsetIn(const FlightFile& file, const void* part) {
  return static_cast<std::uint64_t>(reinterpret_cast<const char*>(part) - reinterpret_cast<const char*>(&file));
}

bool readAll(int fd, void* bytes, std::size_t size) {
  auto* to = static_cast<std::uint8_t*>(bytes);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(fd, to + done, size - done);
    if (got == 0 || (got < 0 && errno != EINTR)) return false;
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  return true;
}

bool isOfLog(const FlightFile& file, const std::string& log) {
  struct stat status {};
  return ::stat(log.c_str(), &status) == 0 && file.log_device == status.st_dev && file.log_inode == status.st_ino;
}

std::string faultOf(const FlightFile& file, const SessionPaths& paths) {
  if (file.magic != FlightFile::kMagic) return "is no flight recorder";
  if (!isOfLog(file, paths.log())) return "belongs to another log";
  const std::string layout = describeFlightFile(file);
  const bool ours =
      file.layout_size == layout.size() && std::memcmp(file.layout.data(), layout.data(), layout.size()) == 0;
  if (!ours) return "was laid out by another version of this program";
  return newestCheckpoint(file) == nullptr ? "has no whole checkpoint" : "";
}

}  // namespace

std::uint64_t checkOf(const SealedCheckpoint& sealed) noexcept {
  std::array<std::uint64_t, 3 + 2 * kRecordKindCount> words{};
  words[0] = sealed.sequence;
  words[1] = sealed.checkpoint.log.size;
  words[2] = sealed.checkpoint.log.next_number;
  for (std::size_t i = 0; i < kRecordKindCount; ++i) {
    words[3 + i] = sealed.checkpoint.heads[i];
    words[3 + kRecordKindCount + i] = sealed.checkpoint.dropped[i];
  }
  return recordChecksum(words, 0);
}

const SealedCheckpoint* newestCheckpoint(const FlightFile& file) noexcept {
  const SealedCheckpoint* newest = nullptr;
  for (const SealedCheckpoint& each : file.checkpoints) {
    const bool whole = each.sequence != 0 && each.check == checkOf(each);
    if (whole && (newest == nullptr || each.sequence > newest->sequence)) newest = &each;
  }
  return newest;
}

std::string describeFlightFile(const FlightFile& file) {
  Json queues = Json::array();
  file.rings.forEach([&](RecordKind kind, const auto& ring) {
    using Ring = std::decay_t<decltype(ring)>;
    using Slot = typename Ring::Slot;
    const Slot slot{};
    queues.push_back({{"kind", static_cast<int>(kind)},
                      {"type", static_cast<int>(RecordTypeOf<typename Ring::Element>::kType)},
                      {"name", kRecordKindNames[static_cast<std::size_t>(kind)]},
                      {"capacity", Ring::kCapacity},
                      {"slots", offsetIn(file, ring.slots())},
                      {"stride", sizeof(Slot)},
                      {"check", reinterpret_cast<const char*>(&slot.check) - reinterpret_cast<const char*>(&slot)},
                      {"tail", offsetIn(file, ring.tailAddress())},
                      {"dropped", offsetIn(file, ring.droppedAddress())},
                      {"size", sizeof(typename Ring::Element)},
                      {"fields", MemoryLayoutWriter::fieldsOf<typename Ring::Element>()}});
  });
  Json checkpoints = Json::array();
  for (const SealedCheckpoint& each : file.checkpoints)
    checkpoints.push_back(offsetIn(file, &each));
  return Json{{"record_version", kRecordVersion}, {"checkpoints", checkpoints}, {"queues", queues}}.dump();
}

std::unique_ptr<FlightFile> readFlightFile(const SessionPaths& paths, std::string* reason) {
  const CloseFile opened{::open(paths.flight().c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (opened.fd < 0) {
    *reason = errno == ENOENT ? "the file does not exist" : std::strerror(errno);
    return nullptr;
  }
  auto file = std::make_unique<FlightFile>();
  // A copy in memory of our own: a file that somebody cuts short while it is mapped would end this process.
  if (!readAll(opened.fd, static_cast<void*>(file.get()), sizeof(FlightFile))) {
    *reason = "is shorter than a flight recorder";
    return nullptr;
  }
  *reason = faultOf(*file, paths);
  if (!reason->empty()) return nullptr;
  return file;
}

}  // namespace raven2_trainer::session
