#include "proxy/impairment_log.h"

#include <cerrno>
#include <cinttypes>
#include <cstring>

#include "raven2_trainer/core/bytes.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::proxy {
namespace {

constexpr std::size_t kTrailerSize = 32;        // of signed ITP, behind the packet
constexpr std::size_t kFileBuffer = 1U << 20U;  // [bytes] seconds of traffic between two writes
const char* const kColumns =
    "link,direction,packet,copy,sequence,bytes,in_ns,action,due_ns,out_ns,flipped_bits,truncated,reordered\n";

std::string text(std::int64_t sequence) {
  return sequence < 0 ? "" : std::to_string(sequence);
}

}  // namespace

ImpairmentLog::ImpairmentLog(const std::string& path, std::int64_t start_ns) : path_(path), start_ns_(start_ns) {
  if (path.empty()) return;
  file_.reset(std::fopen(path.c_str(), "w"));
  if (!file_) throw SessionException(path + ": " + std::strerror(errno));
  buffer_.resize(kFileBuffer);
  std::setvbuf(file_.get(), buffer_.data(), _IOFBF, buffer_.size());
  std::fputs(kColumns, file_.get());
}

std::int64_t ImpairmentLog::sequenceOf(const std::uint8_t* bytes, std::size_t size) noexcept {
  if (size != wire::kItpSize && size != wire::kItpSize + kTrailerSize) return -1;
  ByteReader in(bytes, size);
  return in.get<std::uint32_t>();
}

void ImpairmentLog::dropped(const std::string& where,
                            const impair::Fate& fate,
                            std::int64_t sequence,
                            std::size_t size,
                            std::int64_t now_ns) {
  if (!file_) return;
  std::fprintf(file_.get(), "%s,%" PRIu64 ",0,%s,%zu,%" PRId64 ",%s,,,0,0,0\n", where.c_str(), fate.number,
               text(sequence).c_str(), size, now_ns - start_ns_,
               impair::kLossNames[static_cast<std::size_t>(fate.loss)]);
}

void ImpairmentLog::out(const std::string& where,
                        const impair::Delivery& packet,
                        const char* action,
                        std::int64_t now_ns) {
  if (!file_) return;
  std::fprintf(file_.get(), "%s,%" PRIu64 ",%u,%s,%zu,%" PRId64 ",%s,%" PRId64 ",%" PRId64 ",%u,%d,%d\n", where.c_str(),
               packet.fate.number, packet.copy, text(packet.tag).c_str(), packet.bytes.size(), packet.in_ns - start_ns_,
               action, packet.due_ns - start_ns_, now_ns - start_ns_, packet.fate.flipped_bits,
               packet.fate.is_truncated ? 1 : 0, packet.fate.is_reordered ? 1 : 0);
}

void ImpairmentLog::flush() noexcept {
  if (file_) std::fflush(file_.get());
}

void ImpairmentLog::close() {
  if (!file_) return;
  const bool has_failed = std::ferror(file_.get()) != 0;
  if (std::fclose(file_.release()) != 0 || has_failed) throw SessionException(path_ + ": cannot be written");
}

}  // namespace raven2_trainer::proxy
