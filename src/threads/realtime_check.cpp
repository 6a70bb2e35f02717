#include "raven2_trainer/threads/realtime_check.h"

#include <linux/capability.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <set>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/threads/cyclic_thread.h"

namespace raven2_trainer::threads {
namespace {

namespace fs = std::filesystem;

constexpr int kHeapStep = 8 << 20;  // [bytes] by which the heap grows

/** Being root is not enough: a container's root may lack it. */
bool mayLockAnyAmount() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &header, data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

/** The heap keeps all memory that it had once, locked or not. */
void keepHeap() {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_TOP_PAD, kHeapStep);
}

bool isWorldWritable(const struct stat& status) noexcept {
  return (status.st_mode & S_IWOTH) != 0;
}

bool isSticky(const struct stat& status) noexcept {
  return (status.st_mode & S_ISVTX) != 0;
}

/** The file, its folder, and the folders above. */
void checkPath(const fs::path& file, std::set<std::string>* bad) {
  const fs::path folder = file.parent_path();
  for (fs::path path = file;; path = path.parent_path()) {
    struct stat status {};
    const bool found = ::stat(path.c_str(), &status) == 0;
    const bool is_above = path != file && path != folder;
    if (found && isWorldWritable(status) && !(is_above && isSticky(status))) bad->insert(path.string());
    if (path == path.parent_path()) return;
  }
}

void append(const std::vector<std::string>& more, std::vector<std::string>* reasons) {
  reasons->insert(reasons->end(), more.begin(), more.end());
}

}  // namespace

void takeHeap(std::size_t bytes) {
  keepHeap();
  mallopt(M_MMAP_MAX, 0);
  void* all = std::malloc(bytes);
  if (all == nullptr) return;
  explicit_bzero(all, bytes);  // a memset before a free may be left out
  std::free(all);
}

MemoryLock lockMemory() {
  keepHeap();
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (!mayLockAnyAmount() && limit.rlim_cur != RLIM_INFINITY) {
    return {false, "memory not locked (RLIMIT_MEMLOCK is " + std::to_string(limit.rlim_cur / 1024) + " KiB)"};
  }
  // Programs and libraries that are mapped now are read at once: a line of a loop that runs for the first time an
  // hour from now must not wait for the disk. Later memory (stacks, rings) is locked when it is touched.
  if (mlockall(MCL_CURRENT) != 0 || mlockall(MCL_FUTURE | MCL_ONFAULT) != 0) {
    return {false, std::string("memory not locked (") + std::strerror(errno) + ")"};
  }
  return {true, "memory locked"};
}

std::vector<std::string> preloadReasons(const char* ld_preload, const std::string& preload_file) {
  std::vector<std::string> reasons;
  if (ld_preload != nullptr && ld_preload[0] != '\0') reasons.push_back(std::string("LD_PRELOAD is ") + ld_preload);
  struct stat status {};
  if (::stat(preload_file.c_str(), &status) == 0 && status.st_size > 0)
    reasons.push_back(preload_file + " is not empty");
  return reasons;
}

std::vector<std::string> writableReasons(const std::vector<std::string>& files) {
  std::set<std::string> bad;
  for (const std::string& file : files) {
    std::error_code error;
    checkPath(fs::absolute(file).lexically_normal(), &bad);
    checkPath(fs::weakly_canonical(file, error), &bad);  // what a link leads to, too
  }
  std::vector<std::string> reasons;
  for (const std::string& path : bad)
    reasons.push_back(path + " is writable by everybody");
  return reasons;
}

std::vector<std::string> schedulingReasons(const RuntimeConfig& config) {
  const std::pair<const char*, ThreadConfig> wanted[] = {{"physics", config.physics},
                                                         {"haptic", config.haptic},
                                                         {"ingest", config.ingest},
                                                         {"robot_link", config.robot_link},
                                                         {"sender", config.sender}};
  std::vector<std::string> reasons;
  for (const auto& [name, scheduling] : wanted) {
    Thread probe;
    probe.start(realtimeThread(name, scheduling, config), [] {});
    if (!probe.realtime()) reasons.push_back(probe.refusal());
  }
  return reasons;
}

void demandRealtime(const RuntimeConfig& config, const std::vector<std::string>& files) {
  std::vector<std::string> reasons = schedulingReasons(config);
  const MemoryLock memory = lockMemory();
  if (!memory.locked) reasons.push_back(memory.words);
  append(preloadReasons(std::getenv("LD_PRELOAD"), "/etc/ld.so.preload"), &reasons);
  append(writableReasons(files), &reasons);
  if (reasons.empty()) return;
  std::string text = "--strict:";
  for (const std::string& reason : reasons)
    text += "\n  " + reason;
  throw RealtimeException(text);
}

}  // namespace raven2_trainer::threads
