#include "render/chapters.h"

#include <algorithm>

namespace raven2_trainer::render {

namespace {

std::string words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string faultName(const session::LogHeader& header, std::uint32_t id) {
  return id > 0 && id <= header.scenarios.size() ? words(header.scenarios[id - 1]) : "unknown";
}

std::string stepName(const session::LogHeader& header, const ExerciseEvent& event) {
  if (event.track >= header.step_names.size() || event.step >= header.step_names[event.track].size()) return "unknown";
  const std::string name = words(header.step_names[event.track][event.step]);
  return header.step_names.size() == 1 ? name : name + " (" + std::to_string(event.track + 1) + ")";
}

/** Empty: no chapter. Mistakes and touches are too many to jump to. */
std::string exerciseTitle(const session::LogHeader& header, const ExerciseEvent& event) {
  switch (event.kind) {
    case ExerciseEventKind::kStarted:
      return "New attempt";
    case ExerciseEventKind::kBegan:
      return "Exercise begins";
    case ExerciseEventKind::kStepDone:
      return "Step done: " + stepName(header, event);
    case ExerciseEventKind::kDone:
      return "Exercise done";
    case ExerciseEventKind::kFailed:
      return "Exercise failed";
    default:
      return "";
  }
}

/** One chapter of those that a viewer would not tell apart. */
std::vector<Chapter> joined(const std::vector<Chapter>& chapters) {
  std::vector<Chapter> out;
  for (const Chapter& chapter : chapters) {
    if (out.empty() || chapter.start_ms - out.back().start_ms >= ChapterList::kNearest)
      out.push_back(chapter);
    else
      out.back().title += ", " + chapter.title;
  }
  return out;
}

}  // namespace

void ChapterList::add(const TickRecord& record) {
  const Tick now = record.model.session_tick;
  if (now < 0) return;
  origin_ = record.model.tick - now;
  // The robot's word counts for a fault, as in the picture's banner.
  const std::uint32_t fault = record.robot.active_fault != 0 ? record.robot.active_fault : record.model.faults.active;
  if (fault != fault_) {
    if (fault_ != 0) faults_.push_back({now, fault_, false});
    if (fault != 0) faults_.push_back({now, fault, true});
    fault_ = fault;
  }
  const bool pedal = record.model.pedal != 0;
  if (pedal != pedal_) pedals_.push_back({now, pedal});
  pedal_ = pedal;
}

void ChapterList::add(const ExerciseRecord& record) {
  exercise_.push_back(record);
}

std::vector<Chapter> ChapterList::ofExercise(const session::LogHeader& header) const {
  std::vector<Chapter> out;
  for (const ExerciseRecord& record : exercise_) {
    const std::string title = exerciseTitle(header, record.event);
    if (!title.empty() && record.tick >= origin_) out.push_back({record.tick - origin_, title});
  }
  return out;
}

std::vector<Chapter> ChapterList::chapters(const session::LogHeader& header, std::int64_t from, std::int64_t to) const {
  std::vector<Chapter> events = ofExercise(header);
  for (const FaultEdge& edge : faults_)
    events.push_back({edge.session_tick, (edge.begins ? "Hazard: " : "Hazard ends: ") + faultName(header, edge.id)});
  if (pedals_.size() <= kMaxPedals) {
    for (const PedalEdge& edge : pedals_)
      events.push_back({edge.session_tick, edge.down ? "Pedal down" : "Pedal up"});
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Chapter& a, const Chapter& b) { return a.start_ms < b.start_ms; });
  std::vector<Chapter> inside{{0, "Beginning"}};
  for (const Chapter& event : events) {
    if (event.start_ms >= from && event.start_ms < to) inside.push_back({event.start_ms - from, event.title});
  }
  std::vector<Chapter> out = joined(inside);
  if (out.size() > kMaxChapters) out.resize(kMaxChapters);
  return out;
}

}  // namespace raven2_trainer::render
