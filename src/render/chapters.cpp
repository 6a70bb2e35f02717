#include "render/chapters.h"

#include <algorithm>

#include "raven2_trainer/session/active_fault.h"

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

/** Empty: no chapter. */
std::string beginningOf(Mode mode) {
  if (mode == Mode::kStopped) return "Robot stopped";
  if (mode == Mode::kPaused) return "Time was lost";
  if (mode == Mode::kExecuting) return "Plan begins";
  return "";
}

/** Joins chapters that a viewer could not distinguish. */
void join(const Chapter& chapter, std::vector<Chapter>* chapters) {
  if (chapter.start_ms - chapters->back().start_ms >= ChapterList::kNearest)
    chapters->push_back(chapter);
  else
    chapters->back().title += ", " + chapter.title;
}

}  // namespace

void ChapterList::followFault(const TickRecord& record) {
  const std::uint32_t fault = activeFault(record.model, record.robot);
  if (fault == fault_) return;
  if (fault_ != 0) faults_.push_back({record.model.session_tick, fault_, false});
  if (fault != 0) faults_.push_back({record.model.session_tick, fault, true});
  fault_ = fault;
}

void ChapterList::followMode(const TickRecord& record) {
  const Mode mode = record.model.mode;
  if (mode == mode_) return;
  if (mode_ == Mode::kExecuting) modes_.push_back({record.model.session_tick, Rank::kEnd, "Plan ends"});
  const std::string title = beginningOf(mode);
  if (!title.empty()) modes_.push_back({record.model.session_tick, Rank::kTurn, title});
  mode_ = mode;
}

void ChapterList::followPedal(const TickRecord& record) {
  const bool pedal = record.model.pedal != 0;
  if (pedal != pedal_) pedals_.push_back({record.model.session_tick, Rank::kPedal, pedal ? "Pedal down" : "Pedal up"});
  pedal_ = pedal;
}

void ChapterList::add(const TickRecord& record) {
  if (record.model.session_tick < 0) return;
  clock_.add(record.model);
  followFault(record);
  followMode(record);
  followPedal(record);
}

void ChapterList::add(const ExerciseRecord& record) {
  exercise_.push_back(record);
}

void ChapterList::addExercise(const session::LogHeader& header, std::vector<Event>* events) const {
  for (const ExerciseRecord& record : exercise_) {
    const std::string title = exerciseTitle(header, record.event);
    const Rank rank = record.event.kind == ExerciseEventKind::kStepDone ? Rank::kStep : Rank::kTurn;
    const Tick session_tick = clock_.at(record.tick);
    if (!title.empty() && session_tick >= 0) events->push_back({session_tick, rank, title});
  }
}

/** In order of time. */
std::vector<ChapterList::Event> ChapterList::events(const session::LogHeader& header, bool names_hazards) const {
  std::vector<Event> events;
  addExercise(header, &events);
  for (const FaultEdge& edge : faults_) {
    const std::string title = (edge.begins ? "Hazard: " : "Hazard ends: ") + faultName(header, edge.id);
    if (names_hazards) events.push_back({edge.session_tick, edge.begins ? Rank::kTurn : Rank::kEnd, title});
  }
  events.insert(events.end(), modes_.begin(), modes_.end());
  if (pedals_.size() <= kMaxPedals) events.insert(events.end(), pedals_.begin(), pedals_.end());
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.session_ms < b.session_ms; });
  return events;
}

std::vector<Chapter> ChapterList::chapters(const session::LogHeader& header, const ChapterChoice& choice) const {
  const std::vector<Event> all = events(header, choice.names_hazards);
  std::vector<Chapter> out;
  for (const Rank least : {Rank::kPedal, Rank::kEnd, Rank::kStep, Rank::kTurn}) {
    out = {{0, "Beginning"}};
    for (const Event& event : all) {
      const bool is_inside = event.session_ms >= choice.from && event.session_ms < choice.to;
      if (is_inside && event.rank <= least) join({event.session_ms - choice.from, event.title}, &out);
    }
    if (out.size() <= kMaxChapters) return out;
  }
  out.resize(kMaxChapters);
  return out;
}

}  // namespace raven2_trainer::render
