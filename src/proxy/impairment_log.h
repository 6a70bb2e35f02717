#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/impair/channel.h"

namespace raven2_trainer::proxy {

/** The proxy's CSV: one row for each packet that was dropped, sent or is held at the end; times [ns] from the start. */
class ImpairmentLog {
 public:
  /** @param[in] path none if empty. @throw SessionException if it cannot be written. */
  ImpairmentLog(const std::string& path, std::int64_t start_ns);

  /** Sequence number of a plain or signed ITP packet, -1 for anything else. */
  static std::int64_t sequenceOf(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** @param[in] where link and direction, the first two columns. */
  void dropped(const std::string& where,
               const impair::Fate& fate,
               std::int64_t sequence,
               std::size_t size,
               std::int64_t now_ns);
  /** A packet came out, or is still held; its tag is the sequence number. */
  void out(const std::string& where, const impair::Delivery& packet, const char* action, std::int64_t now_ns);
  void flush() noexcept;
  /** Nothing is written any more. @throw SessionException if some of it could not be written. */
  void close();

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  const std::string path_;
  std::int64_t start_ns_;
  std::vector<char> buffer_;  ///< the file's: outlives it
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace raven2_trainer::proxy
