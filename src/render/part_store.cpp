#include "render/part_store.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::render {

namespace {

namespace fs = std::filesystem;

constexpr const char* kLock = "lock";
constexpr const char* kEnding = ".mp4";

std::string number(std::size_t k) {
  char text[24];
  std::snprintf(text, sizeof(text), "%05zu", k);
  return text;
}

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

}  // namespace

PartStore::PartStore(std::string folder, std::string settings, std::size_t count)
    : folder_(std::move(folder)), settings_(std::move(settings)), names_(count) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw RenderException(folder_ + ": cannot be made: " + error.message());
  lock();
  scan(/*check=*/true);
  removeOthers();
}

PartStore::~PartStore() {
  if (lock_ >= 0) close(lock_);
}

/** A record lock: it dies with this process, and children do not inherit it, so that a killed render leaves none. */
void PartStore::lock() {
  const std::string path = folder_ + "/" + kLock;
  lock_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0) throw RenderException(path + ": " + std::strerror(errno));
  struct flock whole {};
  whole.l_type = F_WRLCK;
  if (fcntl(lock_, F_SETLK, &whole) == 0) return;
  close(lock_);
  throw RenderException(folder_ + ": another process is drawing this video");
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
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    std::size_t k = 0;
    if (std::sscanf(name.c_str(), "part_%zu_", &k) != 1 || k >= names_.size() || !startsWith(name, prefix(k))) continue;
    if (!check || name == prefix(k) + session::fileHash(entry.path().string()) + kEnding) names_[k] = name;
  }
}

/** Drafts of the killed, parts of other settings, damaged ones. */
void PartStore::removeOthers() const {
  std::error_code ignored;  // what cannot be removed disturbs nobody
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    const bool is_part = std::find(names_.begin(), names_.end(), name) != names_.end();
    if (!is_part && name != kLock) fs::remove_all(entry.path(), ignored);
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
  fs::remove_all(folder_, ignored);
}

}  // namespace raven2_trainer::render
