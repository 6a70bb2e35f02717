#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raven2_trainer/threads/runtime_config.h"

// Requirements of a real-time program on its machine. Each function that returns texts returns one for each
// reason against it, in words for the operator; none means all is well.

namespace raven2_trainer::threads {

/** Result of locking the memory. */
struct MemoryLock {
  bool locked{false};
  std::string words{"memory not locked"};
};

/**
 * Locks all memory, present and future, where that can do no harm: without the privilege, a limit that is not infinite
 * lets mlockall succeed and every later thread fail. Mapped code and libraries are read from disk at once,
 * later memory when it is touched. Keeps the heap's pages from being given back.
 */
MemoryLock lockMemory();

/**
 * Takes so much heap at once and keeps it: what grows into it later waits for no page, and the process's memory stays
 * what it was at its start. Blocks of any size come from it. Before other threads allocate.
 */
void takeHeap(std::size_t bytes);

/** Libraries put before ours (Alemzadeh et al., DSN 2016, took a Raven over with one).
 *  @param[in] ld_preload value of LD_PRELOAD, null if not set; preload_file usually /etc/ld.so.preload. */
std::vector<std::string> preloadReasons(const char* ld_preload, const std::string& preload_file);

/** Files, or folders on the way to them, that anybody may change. A sticky folder counts for the files in it alone. */
std::vector<std::string> writableReasons(const std::vector<std::string>& files);

/** Threads to which SCHED_FIFO is refused: tried on a short-lived thread each. */
std::vector<std::string> schedulingReasons(const RuntimeConfig& config);

/** All of the above for this process, memory included. @param[in] files that decide over it. @throw RealtimeException
 * that names every reason. */
void demandRealtime(const RuntimeConfig& config, const std::vector<std::string>& files);

}  // namespace raven2_trainer::threads
