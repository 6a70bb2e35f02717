#include "raven2_trainer/session/flight_recorder.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>

#include "flight_file.h"

namespace raven2_trainer::session {

namespace {

constexpr long kTmpfsMagic = 0x01021994;  // statfs(2)

bool isTmpfs(const std::string& folder) {
  struct statfs status {};
  return ::statfs(folder.c_str(), &status) == 0 && status.f_type == kTmpfsMagic;
}

}  // namespace

FlightRecorder::FlightRecorder(const std::string& folder) {
  if (!map(folder)) memory_ = std::make_unique<RecordRings>();
}

bool FlightRecorder::giveUp(const std::string& reason) {
  description_ = "none: " + reason;
  return false;
}

bool FlightRecorder::map(const std::string& folder) {
  if (folder == "none") return giveUp("switched off");
  if (!isTmpfs(folder)) return giveUp(folder + " is no tmpfs");
  path_ = folder + "/raven2_trainer-XXXXXX";
  const int fd = ::mkostemp(path_.data(), O_CLOEXEC);
  if (fd < 0) return giveUp(path_ + ": " + std::strerror(errno));
  // Allocated, not only sized: a page that the tmpfs has no room for would end the process when it is touched.
  int error = ::posix_fallocate(fd, 0, sizeof(FlightFile));
  void* memory = MAP_FAILED;
  if (error == 0) {
    memory = ::mmap(nullptr, sizeof(FlightFile), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
    if (memory == MAP_FAILED) error = errno;
  }
  ::close(fd);
  if (memory == MAP_FAILED) {
    ::unlink(path_.c_str());
    return giveUp(path_ + ": " + std::strerror(error));
  }
  ::mlock(memory, sizeof(FlightFile));  // where the limit allows it; a tmpfs page leaves memory only for swap
  file_ = new (memory) FlightFile;      // writes every page once
  description_ = path_;
  return true;
}

FlightRecorder::~FlightRecorder() {
  if (file_ == nullptr) return;
  ::munmap(static_cast<void*>(file_), sizeof(FlightFile));
  remove();
}

void FlightRecorder::remove() noexcept {
  if (file_ == nullptr || keep_) return;
  keep_ = true;  // nothing is left to remove
  if (!link_.empty()) ::unlink(link_.c_str());
  ::unlink(path_.c_str());
}

RecordRings* FlightRecorder::rings() noexcept {
  return file_ != nullptr ? &file_->rings : memory_.get();
}

void FlightRecorder::attach(const SessionPaths& paths) {
  if (file_ == nullptr) return;
  const std::string layout = describeFlightFile(*file_);
  struct stat status {};
  const bool fits = layout.size() <= FlightFile::kLayoutCapacity;
  if (!fits || ::stat(paths.log().c_str(), &status) != 0) return;
  std::memcpy(file_->layout.data(), layout.data(), layout.size());
  file_->layout_size = layout.size();
  file_->log_device = status.st_dev;
  file_->log_inode = status.st_ino;
  std::error_code error;
  std::filesystem::create_symlink(path_, paths.flight(), error);
  if (error) {
    description_ = "none: " + paths.flight() + ": " + error.message();
    return;
  }
  link_ = paths.flight();
}

void FlightRecorder::checkpoint(const FlightCheckpoint& checkpoint) noexcept {
  if (file_ == nullptr) return;
  SealedCheckpoint sealed;
  sealed.sequence = ++sequence_;
  sealed.checkpoint = checkpoint;
  sealed.check = checkOf(sealed);
  file_->checkpoints[sequence_ % 2] = sealed;
  std::atomic_thread_fence(std::memory_order_seq_cst);  // before the queues give back room
}

}  // namespace raven2_trainer::session
