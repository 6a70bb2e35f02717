#include "raven2_trainer/campaign/results.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "campaign/csv_row.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::campaign {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw SessionException(path + ": " + what);
}

std::string readText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/** Writes all of it, or leaves the old file. */
void replaceFile(const std::string& path, const std::string& text) {
  const std::string fresh = path + ".new";
  std::ofstream out(fresh, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out || std::rename(fresh.c_str(), path.c_str()) != 0) fail(path, "cannot be written");
}

/** FNV-1a, 64 bit, as session::fileHash. */
std::string hashOf(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text)
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  char hex[17];
  std::snprintf(hex, sizeof(hex), "%016llx", static_cast<unsigned long long>(hash));
  return hex;
}

Json describe(const Experiment& experiment, std::size_t runs) {
  return {{"scenario", experiment.name},       {"runs", runs},
          {"injection", experiment.injection}, {"number", experiment.number},
          {"observed", experiment.observed},   {"published", experiment.published}};
}

Json toJson(const Identity& identity) {
  return {{"name", identity.name},   {"title", identity.title},   {"source", identity.source},
          {"seed", identity.seed},   {"digest", identity.digest}, {"runs", identity.total},
          {"shard", identity.shard}, {"shards", identity.shards}, {"scenarios", Json::parse(identity.experiments)}};
}

std::string textOf(const Identity& identity) {
  return toJson(identity).dump(1) + "\n";
}

Identity readIdentity(const std::string& path) {
  try {
    const Json json = Json::parse(readText(path));
    Identity identity;
    identity.name = json.at("name");
    identity.title = json.at("title");
    identity.source = json.at("source");
    identity.seed = json.at("seed");
    identity.digest = json.at("digest");
    identity.total = json.at("runs");
    identity.shard = json.at("shard");
    identity.shards = json.at("shards");
    identity.experiments = json.at("scenarios").dump();
    return identity;
  } catch (const Json::exception& e) {
    fail(path, std::string("is not what a campaign writes: ") + e.what());
  }
}

void demandSame(const std::string& path, const Identity& found, const Identity& wanted) {
  if (found.digest != wanted.digest)
    fail(path, "is of another campaign, configuration, build or seed (digest " + found.digest + ", here " +
                   wanted.digest + ")");
  if (found.shards != wanted.shards)
    fail(path, "is one of " + std::to_string(found.shards) + " shards, not of " + std::to_string(wanted.shards));
}

std::string table(const std::map<std::uint32_t, std::string>& rows) {
  std::string text = header() + "\n";
  for (const auto& [run, line] : rows)
    text += line + "\n";
  return text;
}

/** Whether an open file is still the one of this path. */
bool isFileAt(const std::string& path, int file) {
  struct stat held = {}, there = {};
  const bool are_known = ::fstat(file, &held) == 0 && ::stat(path.c_str(), &there) == 0;
  return are_known && held.st_dev == there.st_dev && held.st_ino == there.st_ino;
}

/** Lines that end; what comes after the last end of line is torn. */
std::vector<std::string> wholeLines(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

}  // namespace

Identity identify(const Campaign& campaign, const std::map<std::string, std::string>& ingredients) {
  Identity identity;
  identity.name = campaign.name;
  identity.title = campaign.title;
  identity.source = campaign.source;
  identity.seed = campaign.seed;
  identity.total = campaign.runs.size();
  Json experiments = Json::array();
  for (std::size_t i = 0; i < campaign.experiments.size(); ++i) {
    const auto runs = std::count_if(campaign.runs.begin(), campaign.runs.end(),
                                    [i](const CampaignRun& run) { return run.experiment == i; });
    experiments.push_back(describe(campaign.experiments[i], static_cast<std::size_t>(runs)));
  }
  identity.experiments = experiments.dump();
  std::string all = toJson(identity).dump() + header();
  for (const auto& [name, hash] : ingredients)
    all += name + "=" + hash + ";";
  identity.digest = hashOf(all);
  return identity;
}

PartialOutcomes::PartialOutcomes(const OutputPaths& paths,
                                 const Identity& identity,
                                 const Campaign& campaign,
                                 bool resume,
                                 int lock_wait)
    : paths_(paths), identity_(identity) {
  std::error_code error;
  fs::create_directories(paths_.directory, error);
  if (error) fail(paths_.directory, "cannot be created: " + error.message());
  const bool is_new = !fs::exists(paths_.identity());
  for (const std::string& rows : {paths_.outcomes(), paths_.part()}) {
    // A start that was killed before its first run leaves an empty one, of nothing.
    if (is_new && fs::exists(rows) && fs::file_size(rows) != 0) fail(rows, "is there without its campaign.json");
  }
  if (!is_new && !resume) fail(paths_.directory, "already holds a campaign; --resume goes on with it");
  if (!is_new) {
    const Identity found = readIdentity(paths_.identity());
    demandSame(paths_.identity(), found, identity_);
    if (found.shard != identity_.shard) fail(paths_.identity(), "is shard " + std::to_string(found.shard));
  }
  openLocked(lock_wait);
  if (is_new) replaceFile(paths_.identity(), textOf(identity_));
  takeOver(campaign);
}

PartialOutcomes::~PartialOutcomes() {
  if (file_ >= 0) ::close(file_);
}

/** Reads the table of a finished shard, then later results. Runs without an outcome are made again. */
void PartialOutcomes::takeOver(const Campaign& campaign) {
  if (fs::exists(paths_.outcomes())) {
    const std::vector<std::string> lines = wholeLines(readText(paths_.outcomes()));
    for (std::size_t i = 1; i < lines.size() && takeRow(lines[i], campaign); ++i) {
    }
  }
  std::size_t good = 0;
  for (const std::string& line : wholeLines(readText(paths_.part()))) {
    if (!takeRow(line, campaign)) break;
    good += line.size() + 1;
  }
  if (::ftruncate(file_, static_cast<off_t>(good)) != 0) fail(paths_.part(), std::strerror(errno));
}

/** @return false: it is no row of this campaign. */
bool PartialOutcomes::takeRow(const std::string& line, const Campaign& campaign) {
  const std::uint32_t run = runOf(line, campaign);
  if (run != 0 && hasOutcome(line)) rows_[run] = line;
  return run != 0;
}

/** A process that finishes removes its file: who waited for its lock has that of a file that is gone. */
void PartialOutcomes::openLocked(int wait) {
  do {
    if (file_ >= 0) ::close(file_);
    file_ = ::open(paths_.part().c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (file_ < 0) fail(paths_.part(), std::strerror(errno));
    lock(wait);
  } while (!isFileAt(paths_.part(), file_));
}

/** The lock of a node that was lost lives on until its file server notices. */
void PartialOutcomes::lock(int wait) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(wait);
  while (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (std::chrono::steady_clock::now() >= end) fail(paths_.part(), "is being written by another process");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

void PartialOutcomes::add(std::uint32_t run, const std::string& row) {
  const std::string line = row + "\n";
  if (::write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    fail(paths_.part(), std::string("cannot be written: ") + std::strerror(errno));
  rows_[run] = row;
}

void PartialOutcomes::finish() {
  replaceFile(paths_.outcomes(), table(rows_));
  fs::remove(paths_.part());
}

namespace {

/** Reads one shard into the rows of all. */
void addShard(const OutputPaths& paths, const Identity& identity, std::map<std::uint32_t, std::string>* rows) {
  const std::vector<std::string> lines = wholeLines(readText(paths.outcomes()));
  if (lines.empty() || lines.front() != header()) fail(paths.outcomes(), "does not begin with the header of outcomes");
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::uint32_t run = runOf(lines[i]);
    if (run == 0 || run > identity.total)
      fail(paths.outcomes() + ":" + std::to_string(i + 1), "is no outcome of this campaign");
    if (!rows->emplace(run, lines[i]).second)
      fail(paths.outcomes() + ":" + std::to_string(i + 1), "run " + std::to_string(run) + " is given twice");
  }
}

void demandAll(const std::string& what, std::size_t found, std::size_t wanted) {
  if (found != wanted)
    throw SessionException(std::to_string(found) + " " + what + " of " + std::to_string(wanted) + " are there");
}

}  // namespace

void mergeShards(const std::vector<std::string>& directories, const std::string& output) {
  if (directories.empty()) throw SessionException("no shards to merge");
  Identity first = readIdentity(OutputPaths{directories.front()}.identity());
  std::set<std::size_t> shards;
  std::map<std::uint32_t, std::string> rows;
  for (const std::string& directory : directories) {
    const OutputPaths paths{directory};
    const Identity identity = readIdentity(paths.identity());
    demandSame(paths.identity(), identity, first);
    if (!shards.insert(identity.shard).second)
      fail(directory, "is shard " + std::to_string(identity.shard) + ", which was given already");
    addShard(paths, identity, &rows);
  }
  demandAll("shards", shards.size(), first.shards);
  demandAll("runs", rows.size(), first.total);
  const OutputPaths paths{output}, one{directories.front()};
  fs::create_directories(output);
  if (fs::exists(paths.identity())) fail(output, "already holds a campaign");
  first.shard = first.shards = 1;
  if (fs::exists(one.explanations(first.name)))
    fs::copy_file(one.explanations(first.name), paths.explanations(first.name));
  replaceFile(paths.outcomes(), table(rows));
  replaceFile(paths.identity(), textOf(first));
}

}  // namespace raven2_trainer::campaign
