#include <string>

#include "header_json.h"
#include "log_scanner.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "record_codec.h"

namespace raven2_trainer::session {

namespace {

enum class Outcome { kRead, kUnusable };

template <typename T>
bool decode(const FrameHeader& header, const std::uint8_t* payload, T* record) {
  ByteReader in(payload, header.length);
  FieldReader fields(in);
  visitFields(fields, *record);
  return !fields.invalid() && in.left() == 0;
}

/** Decodes the payload as a T for `call`; left alone if nobody asked for it. */
template <typename T>
Outcome deliver(const FrameHeader& header, const std::uint8_t* payload, const std::function<void(const T&)>& call) {
  T record{};
  if (!decode(header, payload, &record)) return Outcome::kUnusable;
  if (call) call(record);
  return Outcome::kRead;
}

/** A type or version of a newer program is passed over: its CRC was right, so nothing is lost but what is unknown. */
Outcome dispatch(const FrameHeader& header, const std::uint8_t* payload, const LogVisitor& visitor) {
  if (header.version != kRecordVersion) return Outcome::kRead;
  switch (header.type) {
    case RecordType::kTick:
      return deliver(header, payload, visitor.tick);
    case RecordType::kHaptic:
      return deliver(header, payload, visitor.haptic);
    case RecordType::kCommand:
      return deliver(header, payload, visitor.command);
    case RecordType::kRequest:
      return deliver(header, payload, visitor.request);
    case RecordType::kPlan:
      return deliver(header, payload, visitor.plan);
    case RecordType::kFaults:
      return deliver(header, payload, visitor.faults);
    case RecordType::kFaultChange:
      return deliver(header, payload, visitor.fault_change);
    case RecordType::kExecution:
      return deliver(header, payload, visitor.execution);
    case RecordType::kExercise:
      return deliver(header, payload, visitor.exercise);
    case RecordType::kContact:
      return deliver(header, payload, visitor.contact);
    case RecordType::kCounts:
      return deliver(header, payload, visitor.counts);
    case RecordType::kGap:
      return deliver(header, payload, visitor.gap);
    case RecordType::kRecovery:
      return deliver(header, payload, visitor.recovery);
    case RecordType::kHeader:
      return Outcome::kUnusable;  // only the first record is one
    case RecordType::kChunk:
      return Outcome::kRead;  // of a later version
  }
  return Outcome::kRead;
}

LogHeader takeHeader(LogScanner* scanner, const std::string& path) {
  FrameHeader header;
  const std::uint8_t* payload = nullptr;
  if (!scanner->next(&header, &payload) || scanner->badBytes() != 0 || header.type != RecordType::kHeader) {
    throw SessionException(path + ": is no session log, or its first record is damaged");
  }
  try {
    return headerFromJson(std::string(reinterpret_cast<const char*>(payload), header.length));
  } catch (const std::exception& error) {
    throw SessionException(path + ": first record: " + error.what());
  }
}

}  // namespace

LogHeader readLogHeader(const std::string& path) {
  LogScanner scanner(path);
  return takeHeader(&scanner, path);
}

struct TickReader::Impl {
  explicit Impl(const std::string& path) : scanner(path), header(takeHeader(&scanner, path)) {}

  LogScanner scanner;
  const LogHeader header;
};

TickReader::TickReader(const std::string& path) : impl_(std::make_unique<Impl>(path)) {}

TickReader::~TickReader() = default;

const LogHeader& TickReader::header() const noexcept {
  return impl_->header;
}

std::uint64_t TickReader::position() const noexcept {
  return impl_->scanner.position();
}

bool TickReader::next(TickRecord* record) {
  FrameHeader header;
  const std::uint8_t* payload = nullptr;
  while (impl_->scanner.next(&header, &payload)) {
    if (header.type != RecordType::kTick || header.version != kRecordVersion) continue;
    *record = TickRecord{};
    if (decode(header, payload, record)) return true;
    impl_->scanner.reject();
  }
  return false;
}

LogSummary readLog(const std::string& path, const LogVisitor& visitor) {
  LogScanner scanner(path);
  LogSummary summary;
  summary.header = takeHeader(&scanner, path);
  FrameHeader header;
  const std::uint8_t* payload = nullptr;
  while (scanner.next(&header, &payload)) {
    if (dispatch(header, payload, visitor) == Outcome::kUnusable) {
      scanner.reject();
      continue;
    }
    ++summary.records;
    if (visitor.position) visitor.position(scanner.position());
    if (header.type == RecordType::kCounts) summary.clean = true;
    if (header.type == RecordType::kRecovery) summary.recovered = true;
  }
  summary.bad_bytes = scanner.badBytes();
  summary.truncated_bytes = scanner.truncatedBytes();
  return summary;
}

}  // namespace raven2_trainer::session
