#include "render/part_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <regex>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::render {

namespace {

namespace fs = std::filesystem;
using Files = PartFolderFiles;

constexpr const char* kEnding = ".mp4";

std::string number(std::size_t k) {
  char text[24];
  std::snprintf(text, sizeof(text), "%05zu", k);
  return text;
}

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/** Whether it is a file that a render writes into its folder of parts. */
bool isOurs(const fs::directory_entry& entry) {
  static const std::regex names(
      R"(lock|parts\.ffconcat|chapters\.ffmeta|tones\.wav|whole(_\d+)?\.mp4|draft_\d{5,}_\d+|)"
      R"(part_\d{5,}_[0-9a-f]+_[0-9a-f]{16}\.mp4)");
  std::error_code error;
  return fs::is_regular_file(entry.symlink_status(error)) && std::regex_match(entry.path().filename().string(), names);
}

std::vector<fs::directory_entry> entriesOf(const std::string& folder) {
  std::error_code error;
  std::vector<fs::directory_entry> out;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    out.push_back(*entry);
  return out;
}

/** A folder with a lock is one that a render has made, whatever somebody put into it since. */
void refuseForeign(const std::string& folder) {
  std::error_code error;
  if (fs::is_regular_file(folder + "/" + Files::kLock, error)) return;
  for (const fs::directory_entry& entry : entriesOf(folder)) {
    if (isOurs(entry)) continue;
    throw RenderException(folder + ": is no folder of a video's parts (" + entry.path().filename().string() +
                          " is in it), and nothing is written into it; move it away, or give the video another name");
  }
}

}  // namespace

std::string PartFolderFiles::whole() {
  return "whole_" + std::to_string(getpid()) + kEnding;
}

PartFolderLock::PartFolderLock(const std::string& folder) {
  refuseForeign(folder);
  while (!take(folder)) {
  }
}

PartFolderLock::~PartFolderLock() {
  if (file_ >= 0) close(file_);
}

/** @return false where another process removed the folder meanwhile: it has finished the video. */
bool PartFolderLock::take(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw RenderException(folder + ": cannot be made: " + error.message());
  const std::string path = folder + "/" + Files::kLock;
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0 && errno == ENOENT) return false;
  if (file_ < 0) throw RenderException(path + ": " + std::strerror(errno));
  struct flock whole {};
  whole.l_type = F_WRLCK;
  const bool is_free = fcntl(file_, F_SETLK, &whole) == 0;
  struct stat locked {
  }, there{};
  const bool is_it = fstat(file_, &locked) == 0 && stat(path.c_str(), &there) == 0 && locked.st_dev == there.st_dev &&
                     locked.st_ino == there.st_ino;
  if (is_free && is_it) return true;
  close(file_);
  file_ = -1;
  if (is_free) return false;  // the lock of a file that is gone keeps nobody out
  throw RenderException(folder + ": another process is drawing this video");
}

PartStore::PartStore(std::string folder, std::string settings, std::size_t count)
    : folder_(std::move(folder)), settings_(std::move(settings)), names_(count), lock_(folder_) {
  scan(/*check=*/true);
  removeFiles(/*except=*/names_);
}

std::string PartStore::prefix(std::size_t k) const {
  return "part_" + number(k) + "_" + settings_ + "_";
}

std::string PartStore::draft(std::size_t k) const {
  return folder_ + "/draft_" + number(k) + "_" + std::to_string(getpid());
}

void PartStore::keep(std::size_t k) const {
  const std::string from = draft(k), to = folder_ + "/" + prefix(k) + session::fileHash(from) + kEnding;
  if (std::rename(from.c_str(), to.c_str()) != 0) throw RenderException(to + ": " + std::strerror(errno));
}

void PartStore::scan(bool check) {
  for (const fs::directory_entry& entry : entriesOf(folder_)) {
    const std::string name = entry.path().filename().string();
    std::size_t k = 0;
    if (!isOurs(entry) || std::sscanf(name.c_str(), "part_%zu_", &k) != 1) continue;
    if (k >= names_.size() || !startsWith(name, prefix(k))) continue;
    if (!check || name == prefix(k) + session::fileHash(entry.path().string()) + kEnding) names_[k] = name;
  }
}

/** Our files, except the lock. Files that cannot be removed do no harm. */
void PartStore::removeFiles(const std::vector<std::string>& except) const {
  std::error_code ignored;
  for (const fs::directory_entry& entry : entriesOf(folder_)) {
    const std::string name = entry.path().filename().string();
    const bool stays = name == Files::kLock || std::find(except.begin(), except.end(), name) != except.end();
    if (!stays && isOurs(entry)) fs::remove(entry.path(), ignored);
  }
}

std::vector<std::size_t> PartStore::missing() const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (names_[k].empty()) out.push_back(k);
  }
  return out;
}

std::vector<std::string> PartStore::names() {
  scan(/*check=*/false);
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (names_[k].empty()) throw RenderException(folder_ + ": part " + std::to_string(k) + " is missing");
  }
  return names_;
}

void PartStore::remove() {
  std::error_code ignored;
  removeFiles(/*except=*/{});
  fs::remove(folder_ + "/" + Files::kLock,
             ignored);  // a process that locks its file from here on finds that it is gone
  fs::remove(folder_, ignored);
}

}  // namespace raven2_trainer::render
