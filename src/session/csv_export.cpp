#include "raven2_trainer/session/csv_export.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/active_fault.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

namespace {

constexpr std::size_t kBlock = 1024 * 1024;     // [bytes] written at a time
constexpr std::uint64_t kProgressEvery = 1000;  // [ticks]

/** The part of a haptic record that the export needs. */
struct Force {
  Tick tick{};
  PerArm<Vec3> force_B{};
};

/** First pass: forces, and how many ticks there are. Haptic records may come after later ticks in the file. */
struct Survey {
  std::vector<Force> forces;
  std::uint64_t ticks{0};
};

/** Appends comma-separated cells to a file. Doubles in the shortest form that reads back as the same bits. */
class CsvFile {
 public:
  explicit CsvFile(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "wb")) {
    if (file_ == nullptr) throw SessionException(path + ": cannot be created");
    text_.reserve(kBlock + 4096);
  }
  ~CsvFile() {
    if (file_ != nullptr) std::fclose(file_);
  }
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  void cell(const char* value) { text_.append(value) += ','; }

  template <typename Number>
  void number(Number value) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text_.append(digits.data(), end) += ',';
  }

  template <std::size_t kSize>
  void numbers(const std::array<double, kSize>& values) {
    for (const double value : values)
      number(value);
  }

  void blanks(std::size_t count) { text_.append(count, ','); }

  void quoted(const std::string& value) {
    text_ += '"';
    for (const char c : value)
      text_.append(c == '"' ? 2 : 1, c);
    text_ += "\",";
  }

  void endRow() {
    text_.back() = '\n';
    if (text_.size() >= kBlock) flush();
  }

  void close() {
    flush();
    std::FILE* open = file_;
    file_ = nullptr;
    if (std::fclose(open) != 0) throw SessionException(path_ + ": cannot be written");
  }

 private:
  void flush() {
    if (std::fwrite(text_.data(), 1, text_.size(), file_) != text_.size()) {
      throw SessionException(path_ + ": cannot be written");
    }
    text_.clear();
  }

  std::string path_;
  std::FILE* file_;
  std::string text_;
};

/** Second pass: a row a tick and arm. */
class TickTable {
 public:
  TickTable(CsvFile& csv, const LogHeader& header, const std::vector<Force>& forces)
      : csv_(csv), header_(header), forces_(forces) {
    writeTitles();
  }

  void add(const TickRecord& record) {
    if (record.model.session_tick < 0) return;
    while (next_force_ < forces_.size() && forces_[next_force_].tick <= record.model.tick)
      ++next_force_;
    for (const Arm arm : kArms)
      writeRow(record, arm);
  }

  std::size_t rows() const { return rows_; }

 private:
  void titles(const char* stem) {
    for (std::size_t j = 1; j <= kJointCount; ++j)
      csv_.cell((stem + std::to_string(j)).c_str());
  }

  void writeTitles() {
    for (const char* title : {"tick", "t_s", "arm", "mode", "runlevel", "pedal"})
      csv_.cell(title);
    for (const char* stem : {"q", "dq", "tau", "rq", "rdq"})
      titles(stem);
    for (const char* title : {"px", "py", "pz", "rpx", "rpy", "rpz", "fx", "fy", "fz", "fault"})
      csv_.cell(title);
    csv_.endRow();
  }

  void writeRow(const TickRecord& record, Arm arm) {
    const ModelState& model = record.model;
    const ArmState& state = at(model.arms, arm);
    const bool has_robot = record.robot.frame > 0;
    csv_.number(model.session_tick);
    csv_.number(static_cast<double>(model.session_tick) / 1000.0);
    csv_.cell(name(arm));
    csv_.cell(kModeNames[static_cast<std::size_t>(model.mode)]);
    has_robot ? csv_.number(static_cast<int>(record.robot.runlevel)) : csv_.blanks(1);
    csv_.number(static_cast<int>(model.pedal));
    csv_.numbers(state.q);
    csv_.numbers(state.dq);
    csv_.numbers(state.tau);
    const RobotArmState& robot = at(record.robot.arms, arm);
    has_robot ? writeJoints(robot) : csv_.blanks(2 * kJointCount);
    csv_.numbers(state.p_BT);
    has_robot ? csv_.numbers(robot.p_BT) : csv_.blanks(3);
    csv_.numbers(next_force_ > 0 ? at(forces_[next_force_ - 1].force_B, arm) : Vec3{});
    writeFault(activeFault(model, record.robot));
    csv_.endRow();
    ++rows_;
  }

  void writeJoints(const RobotArmState& robot) {
    csv_.numbers(robot.q);
    csv_.numbers(robot.dq);
  }

  void writeFault(std::uint32_t id) {
    if (id == 0) {
      csv_.blanks(1);
    } else if (id <= header_.scenarios.size()) {
      writeName(header_.scenarios[id - 1]);
    } else {
      csv_.cell(("fault_" + std::to_string(id)).c_str());
    }
  }

  void writeName(const std::string& scenario) {
    const bool plain = scenario.find_first_of(",\"\r\n") == std::string::npos;
    plain ? csv_.cell(scenario.c_str()) : csv_.quoted(scenario);
  }

  CsvFile& csv_;
  const LogHeader& header_;
  const std::vector<Force>& forces_;
  std::size_t next_force_{0};  ///< first one later than the current tick
  std::size_t rows_{0};
};

LogHeader survey(const std::string& log_path, Survey* found) {
  LogVisitor visitor;
  visitor.tick = [&](const TickRecord&) { ++found->ticks; };
  visitor.haptic = [&](const HapticRecord& record) {
    found->forces.push_back({record.haptic.tick, record.haptic.force_B});
  };
  return readLog(log_path, visitor).header;
}

}  // namespace

std::size_t exportTicksCsv(const std::string& log_path,
                           const std::string& csv_path,
                           const std::function<void(double)>& progress) {
  Survey found;
  const LogHeader header = survey(log_path, &found);
  CsvFile csv(csv_path);
  TickTable table(csv, header, found.forces);
  std::uint64_t done = 0;
  LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) {
    table.add(record);
    if (progress && ++done % kProgressEvery == 0)
      progress(static_cast<double>(done) / static_cast<double>(found.ticks));
  };
  readLog(log_path, visitor);
  csv.close();
  if (progress) progress(1.0);
  return table.rows();
}

}  // namespace raven2_trainer::session
