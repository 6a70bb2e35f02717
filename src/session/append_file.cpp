#include "append_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace raven2_trainer::session {

namespace {

constexpr std::uint64_t kChunk = 4U << 20U;  // [bytes] allocated ahead at once: 6 s of a session

/** EIO stands for a file that is shorter than what was written to it: somebody cut or replaced it. */
constexpr int kCutByOthers = EIO;

}  // namespace

bool AppendFile::fail() noexcept {
  error_ = errno;
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  return false;
}

bool AppendFile::open(int flags) noexcept {
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | flags, 0644);
  return fd_ >= 0 || fail();
}

bool AppendFile::create(const std::string& path) noexcept {
  path_ = path;
  size_ = reserved_ = 0;
  return open(O_CREAT | O_TRUNC);
}

bool AppendFile::rename(const std::string& path) noexcept {
  if (::rename(path_.c_str(), path.c_str()) != 0) return fail();
  path_ = path;
  return true;
}

bool AppendFile::resume(const std::string& path, std::uint64_t size) noexcept {
  path_ = path;
  size_ = size;
  reserved_ = size + 1;  // its writer may have left room behind its end: close() gives it back
  return takeUp();
}

/** Opens the file again and cuts off what a failed piece may have left. */
bool AppendFile::takeUp() noexcept {
  if (!open(0)) return false;
  struct stat status {};
  if (::fstat(fd_, &status) != 0) return fail();
  const auto found = static_cast<std::uint64_t>(status.st_size);
  if (S_ISREG(status.st_mode) && found < size_) {
    errno = kCutByOthers;
    return fail();
  }
  if (S_ISREG(status.st_mode) && found > size_) {
    if (::ftruncate(fd_, static_cast<off_t>(size_)) != 0) return fail();
    reserved_ = size_;  // the cut gave it back
  }
  return true;
}

bool AppendFile::reserve(std::uint64_t end) noexcept {
  if (!can_reserve_ || end <= reserved_) return true;
  for (const std::uint64_t ahead : {kChunk, std::uint64_t{0}}) {
    const auto length = static_cast<off_t>(end + ahead - size_);
    if (::fallocate(fd_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(size_), length) == 0) {
      reserved_ = end + ahead;
      return true;
    }
    if (errno == EOPNOTSUPP || errno == ENODEV || errno == ESPIPE || errno == ENOSYS) {
      can_reserve_ = false;
      return true;
    }
  }
  return false;
}

bool AppendFile::writeAll(const void* bytes, std::size_t size) noexcept {
  const auto* from = static_cast<const std::uint8_t*>(bytes);
  for (std::size_t done = 0; done < size;) {
    const ssize_t wrote = ::pwrite(fd_, from + done, size - done, static_cast<off_t>(size_ + done));
    if (wrote > 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (wrote == 0 || errno != EINTR) {
      if (wrote == 0) errno = ENOSPC;
      return false;
    }
  }
  return true;
}

bool AppendFile::append(const void* bytes, std::size_t size, bool use_reserve) noexcept {
  if (fd_ < 0 && !takeUp()) return false;
  if (!use_reserve && !reserve(size_ + size + kReserve)) return fail();
  if (!writeAll(bytes, size)) {
    error_ = errno;
    if (::ftruncate(fd_, static_cast<off_t>(size_)) == 0) reserved_ = size_;
    errno = error_;
    return fail();
  }
  size_ += size;
  return true;
}

bool AppendFile::sync() noexcept {
  if (fd_ < 0) return true;
  if (::fdatasync(fd_) == 0 || errno == EINVAL || errno == EROFS) return true;  // no regular file: nothing to force
  error_ = errno;
  return false;
}

bool AppendFile::close() noexcept {
  if (fd_ < 0) return true;
  if (reserved_ > size_ && ::ftruncate(fd_, static_cast<off_t>(size_)) != 0) error_ = errno;
  const int fd = fd_;
  fd_ = -1;
  if (::close(fd) == 0) return true;
  error_ = errno;
  return false;
}

}  // namespace raven2_trainer::session
