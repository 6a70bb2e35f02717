#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "header_json.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "record_codec.h"
#include "record_frame.h"

namespace raven2_trainer::session {

namespace {

/** [bytes] What a killed process can lose: about 40 ticks. Larger is not faster at 3 MB/s. */
constexpr std::size_t kFileBuffer = 64 * 1024;

}  // namespace

struct LogWriter::Impl {
  std::string path;
  std::FILE* file{nullptr};
  std::uint64_t next_number{0};
  std::vector<std::uint8_t> frame;

  Impl(const std::string& file_path, const LogHeader& header) : path(file_path), file(std::fopen(path.c_str(), "wb")) {
    if (file == nullptr) fail("cannot be created");
    std::setvbuf(file, nullptr, _IOFBF, kFileBuffer);
    frame.resize(kFrameHeaderSize + kMaxPayload + kCrcSize);
    writeHeader(headerToJson(header));
  }

  ~Impl() {
    if (file != nullptr) std::fclose(file);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw SessionException(path + ": " + what + (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  }

  void writeHeader(const std::string& json) {
    if (json.size() > kMaxHeaderPayload) {
      errno = 0;
      fail("header of " + std::to_string(json.size()) + " bytes, at most " + std::to_string(kMaxHeaderPayload));
    }
    std::vector<std::uint8_t> bytes(kFrameHeaderSize + json.size() + kCrcSize);
    std::memcpy(bytes.data() + kFrameHeaderSize, json.data(), json.size());
    seal(RecordType::kHeader, json.size(), bytes.data());
  }

  template <typename T>
  void write(const T& record) {
    ByteWriter out(frame.data() + kFrameHeaderSize, kMaxPayload);
    FieldWriter fields(out);
    Layout<T>::visit(fields, record);
    seal(RecordTypeOf<T>::kType, out.size(), frame.data());
  }

  /** Puts header and CRC around the payload already in place and writes it all in one call. */
  void seal(RecordType type, std::size_t payload, std::uint8_t* bytes) {
    if (file == nullptr) {
      errno = 0;
      fail("the log is finished, no record can follow");
    }
    encodeFrameHeader({kMagic, type, kRecordVersion, static_cast<std::uint32_t>(payload), next_number++}, bytes);
    const std::size_t size = kFrameHeaderSize + payload;
    const std::uint32_t crc = crc32Of(bytes, size);
    std::memcpy(bytes + size, &crc, kCrcSize);
    if (std::fwrite(bytes, 1, size + kCrcSize, file) != size + kCrcSize) fail("cannot be written");
  }

  void close() {
    std::FILE* open = file;
    file = nullptr;
    if (std::fclose(open) != 0) fail("cannot be written");
  }
};

LogWriter::LogWriter(const std::string& path, const LogHeader& header) : impl_(new Impl(path, header)) {}

LogWriter::~LogWriter() = default;

void LogWriter::write(const TickRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const HapticRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const CommandRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const RequestRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const PlanRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const FaultRecord& record) {
  impl_->write(record);
}

void LogWriter::write(const ContactRecord& record) {
  impl_->write(record);
}

void LogWriter::finish(const SessionCounts& counts) {
  impl_->write(counts);
  impl_->close();
}

}  // namespace raven2_trainer::session
