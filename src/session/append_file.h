#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace raven2_trainer::session {

/**
 * A file that only grows, by whole pieces: append() writes all of a piece or leaves the file as it was. After a
 * failure the file is closed and the next append() opens it again, so that a disk that was full, read-only or away is
 * taken up where it left off. Room for kReserve more bytes is kept allocated behind the end, so that the last piece
 * fits on a full disk (not on file systems that cannot allocate ahead).
 */
class AppendFile {
 public:
  static constexpr std::uint64_t kReserve = 1U << 20U;  ///< [bytes] gap record and counters take 2 KiB of them

  AppendFile() = default;
  ~AppendFile() { close(); }
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /** A new, empty file. @return false with error() set. */
  bool create(const std::string& path) noexcept;
  /** Gives the file its final name. @return false with error() set. */
  bool rename(const std::string& path) noexcept;
  /** An existing one, cut to `size`. @return false with error() set. */
  bool resume(const std::string& path, std::uint64_t size) noexcept;

  /** @param use_reserve for the last piece. @return false with error() set, nothing appended. */
  bool append(const void* bytes, std::size_t size, bool use_reserve = false) noexcept;
  /** Forces what was appended to the disk. @return false with error() set. */
  bool sync() noexcept;
  /** Gives back the reserve. @return false with error() set if the system reports a late failure. */
  bool close() noexcept;

  /** [bytes] appended so far. */
  std::uint64_t size() const noexcept { return size_; }
  /** errno of the last failure. */
  int error() const noexcept { return error_; }

 private:
  bool open(int flags) noexcept;
  bool takeUp() noexcept;
  bool reserve(std::uint64_t end) noexcept;
  bool writeAll(const void* bytes, std::size_t size) noexcept;
  bool fail() noexcept;

  std::string path_;
  int fd_{-1};
  std::uint64_t size_{0};
  std::uint64_t reserved_{0};  ///< [bytes] the file has room up to here
  bool can_reserve_{true};
  int error_{0};
};

}  // namespace raven2_trainer::session
