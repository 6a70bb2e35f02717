#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "append_file.h"
#include "header_json.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "record_chunk.h"
#include "record_codec.h"
#include "record_frame.h"

namespace raven2_trainer::session {

namespace {

/** [bytes] A batch without a commit is written at this size; the recorder's largest, all queues full, is 10 MiB. */
constexpr std::size_t kMaxBatch = 16U << 20U;
constexpr std::size_t kWorthAChunk = 32U << 10U;  // [bytes] a smaller batch, 10 ms, is written as it is
constexpr int kLockTries = 20;
constexpr unsigned kLockWait = 5000;  // [us]

}  // namespace

struct LogWriter::Impl {
  std::string path;
  AppendFile file;
  int lock{-1};
  std::uint64_t next_number{0};       ///< of the next record, the batch included
  std::uint64_t committed_number{0};  ///< of the first record that is not in the file
  std::vector<std::uint8_t> batch, frame, chunks;
  std::size_t plain{0};  ///< [bytes] at the end of the batch that no chunk takes: the log's first or last record
  ChunkPacker packer;
  bool finished{false};

  Impl(const std::string& file_path, const std::optional<TickConstants>& constants)
      : path(file_path), frame(kFrameHeaderSize + kMaxPayload + kCrcSize), packer(constants) {}

  ~Impl() {
    commit();
    file.close();
    if (lock >= 0) ::close(lock);
  }

  /** Shows recoveries in other processes that this log has a living writer; the system releases it with the process. */
  void takeLock(const std::string& name) {
    lock = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
    // Others hold it for an instant when they look whether the log is abandoned.
    for (int i = 0; i < kLockTries && lock >= 0; ++i) {
      if (::flock(lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
      ::usleep(kLockWait);
    }
    fail("is being written by another program");
  }

  /** Whether another writer has a log of this name. Both may have found the folder empty. */
  bool isTaken() const noexcept {
    const int other = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (other < 0) return false;
    const bool taken = ::flock(other, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ::close(other);
    return taken;
  }

  /** Header and lock are in place when the log gets its name: nobody ever sees one without. */
  void create(const std::string& json) {
    std::error_code none;
    const bool is_device = std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
    const std::string first = is_device ? path : path + ".new";
    if (!file.create(first)) fail("cannot be created", file.error());
    takeLock(first);
    writeHeader(json);
    const bool is_taken = !is_device && isTaken();
    const bool written = !is_taken && commit() && (is_device || file.rename(path));
    if (written) return;
    if (!is_device) ::unlink(first.c_str());
    is_taken ? fail("is being written by another program") : fail("cannot be written", file.error());
  }

  [[noreturn]] void fail(const std::string& what, int error = 0) const {
    throw SessionException(path + ": " + what + (error != 0 ? std::string(": ") + std::strerror(error) : ""));
  }

  void writeHeader(const std::string& json) {
    if (json.size() > kMaxHeaderPayload) {
      fail("header of " + std::to_string(json.size()) + " bytes, at most " + std::to_string(kMaxHeaderPayload));
    }
    std::vector<std::uint8_t> bytes(kFrameHeaderSize + json.size() + kCrcSize);
    std::memcpy(bytes.data() + kFrameHeaderSize, json.data(), json.size());
    plain = seal(RecordType::kHeader, json.size(), bytes.data());
  }

  /** @return [bytes] of its frame. */
  template <typename T>
  std::size_t write(const T& record) {
    ByteWriter out(frame.data() + kFrameHeaderSize, kMaxPayload);
    FieldWriter fields(out);
    visitFields(fields, record);
    return seal(RecordTypeOf<T>::kType, out.size(), frame.data());
  }

  /** Puts the header before the payload already in place and adds the frame to the batch. @return [bytes] of it. */
  std::size_t seal(RecordType type, std::size_t payload, std::uint8_t* bytes) {
    if (finished) fail("the log is finished, no record can follow");
    if (batch.size() > kMaxBatch && !commit()) fail("cannot be written", file.error());
    encodeFrameHeader({kMagic, type, kRecordVersion, static_cast<std::uint32_t>(payload), next_number++}, bytes);
    const std::size_t size = kFrameHeaderSize + payload + kCrcSize;
    batch.insert(batch.end(), bytes, bytes + size);
    return size;
  }

  /** Writes the CRC of each frame from `begin` on. Those that go into chunks need none. */
  void sign(std::size_t begin) noexcept {
    while (begin < batch.size()) {
      std::uint8_t* bytes = batch.data() + begin;
      const std::size_t size = kFrameHeaderSize + decodeFrameHeader(bytes).length;
      const std::uint32_t crc = crc32Of(bytes, size);
      std::memcpy(bytes + size, &crc, kCrcSize);
      begin += size + kCrcSize;
    }
  }

  bool commit(bool use_reserve = false) noexcept {
    if (batch.empty()) return true;
    const bool is_packed = packed();
    if (!is_packed) sign(0);
    const std::vector<std::uint8_t>& bytes = is_packed ? chunks : batch;
    const bool written = file.append(bytes.data(), bytes.size(), use_reserve);
    batch.clear();
    plain = 0;
    (written ? committed_number : next_number) = written ? next_number : committed_number;
    return written;
  }

  /** Makes `chunks` of the batch. @return false if that is not worth it, or memory lacks. */
  bool packed() noexcept try {
    const std::size_t size = batch.size() - plain;
    if (size < kWorthAChunk) return false;
    chunks.clear();
    packer.pack(batch.data(), size, &chunks);
    sign(size);
    chunks.insert(chunks.end(), batch.end() - static_cast<std::ptrdiff_t>(plain), batch.end());
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }

  /** Makes a chunk of the largest size, for the memory that this takes. */
  void warmUp() {
    if (!batch.empty()) return;
    const std::uint64_t number = next_number;
    while (batch.size() < kMaxChunkRecords)
      write(TickRecord{});
    packed();
    batch.clear();
    next_number = number;
  }

  /** Writes the batch and `record`, the log's last. */
  template <typename T>
  void end(const T& record) {
    plain = write(record);
    if (!commit(/*use_reserve=*/true)) fail("cannot be written", file.error());
    finished = true;
    file.sync();
    if (!file.close()) fail("cannot be written", file.error());
  }
};

LogWriter::LogWriter(const std::string& path, const LogHeader& header, const std::optional<TickConstants>& constants)
    : impl_(new Impl(path, constants)) {
  impl_->create(headerToJson(header));
}

LogWriter::LogWriter(const std::string& path, const LogPosition& position) : impl_(new Impl(path, std::nullopt)) {
  impl_->takeLock(path);
  impl_->next_number = impl_->committed_number = position.next_number;
  if (!impl_->file.resume(path, position.size)) impl_->fail("cannot be written", impl_->file.error());
}

LogWriter::~LogWriter() = default;

template <typename T>
void LogWriter::write(const T& record) {
  impl_->write(record);
}
template void LogWriter::write(const TickRecord&);
template void LogWriter::write(const HapticRecord&);
template void LogWriter::write(const CommandRecord&);
template void LogWriter::write(const RequestRecord&);
template void LogWriter::write(const PlanRecord&);
template void LogWriter::write(const FaultRecord&);
template void LogWriter::write(const FaultChangeRecord&);
template void LogWriter::write(const ExecutionRecord&);
template void LogWriter::write(const ExerciseRecord&);
template void LogWriter::write(const ContactRecord&);
template void LogWriter::write(const GapRecord&);

void LogWriter::reserve(std::size_t bytes) {
  const std::vector<std::uint8_t> held = impl_->batch;
  impl_->batch.resize(std::max(bytes, held.size()));  // writes every byte
  impl_->batch = held;                                // keeps the room
  impl_->chunks.resize(bytes);
  impl_->warmUp();
}

bool LogWriter::commit() noexcept {
  return impl_->commit();
}

bool LogWriter::sync() noexcept {
  return impl_->file.sync();
}

LogPosition LogWriter::position() const noexcept {
  return {impl_->file.size(), impl_->committed_number};
}

int LogWriter::error() const noexcept {
  return impl_->file.error();
}

void LogWriter::finish(const SessionCounts& counts) {
  impl_->end(counts);
}

void LogWriter::finishRecovery(const RecoveryRecord& recovery) {
  impl_->end(recovery);
}

}  // namespace raven2_trainer::session
