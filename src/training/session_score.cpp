#include "raven2_trainer/training/session_score.h"

#include <deque>
#include <utility>

#include "raven2_trainer/training/session_metrics.h"
#include "training/attempt_collector.h"
#include "training/hazard_collector.h"

namespace raven2_trainer::training {

namespace {

/** Records of other threads may come before their tick: they wait for it. */
template <typename Record>
class Waiting {
 public:
  void push(Tick tick, const Record& record) { records_.push_back({tick, record}); }
  template <typename Use>
  void release(Tick now, Use use) {
    for (; !records_.empty() && records_.front().tick <= now; records_.pop_front())
      use(records_.front().tick, records_.front().record);
  }

 private:
  struct Stamped {
    Tick tick;
    Record record;
  };
  std::deque<Stamped> records_;
};

/** Reads a log into a collector, which gets the records of other threads once it has their tick. */
template <typename Collector>
class Scan {
 public:
  Scan(Collector* collector, std::function<void()> on_tick) : collector_(collector), on_tick_(std::move(on_tick)) {}

  void read(const std::string& log_path) {
    session::LogVisitor visitor;
    visitor.tick = [this](const TickRecord& record) { add(record); };
    visitor.request = [this](const RequestRecord& record) { collector_->add(record); };
    visitor.exercise = [this](const ExerciseRecord& record) { collector_->add(record); };
    visitor.haptic = [this](const HapticRecord& record) {
      forces_.push(record.haptic.tick, record);
      release();
    };
    visitor.contact = [this](const ContactRecord& record) {
      contacts_.push(record.tick, record);
      release();
    };
    session::readLog(log_path, visitor);
  }

 private:
  void add(const TickRecord& record) {
    if (on_tick_) on_tick_();
    collector_->add(record);
    now_ = record.model.tick;
    release();
  }

  void release() {
    const auto use = [this](Tick tick, const auto& record) { collector_->addLater(tick, record); };
    forces_.release(now_, use);
    contacts_.release(now_, use);
  }

  Collector* collector_;
  Waiting<HapticRecord> forces_;
  Waiting<ContactRecord> contacts_;
  std::function<void()> on_tick_;
  Tick now_{-1};
};

/** Of a session without a fault nothing is read. */
void scoreHazards(const std::string& log_path, const ScoreSettings& settings, SessionScore* score) {
  const SessionMetrics metrics = computeMetrics(log_path, settings.on_tick);
  if (metrics.faults.empty()) return;
  HazardCollector hazards(settings, metrics);
  Scan(&hazards, settings.on_tick).read(log_path);
  score->hazards = hazards.take();
  score->hazards_beyond = hazards.beyond();
}

std::vector<TickSpan> answersTo(const std::vector<HazardScore>& hazards) {
  std::vector<TickSpan> answers;
  for (const HazardScore& hazard : hazards) {
    const Tick begin = hazard.injection + hazard.response.cue_after;
    if (hazard.response.answer_time > 0) answers.push_back({begin, begin + hazard.response.answer_time});
  }
  return answers;
}

std::vector<HazardScore> hazardsIn(const AttemptOutcome& outcome, const std::vector<HazardScore>& all) {
  std::vector<HazardScore> own;
  for (const HazardScore& hazard : all) {
    if (hazard.injection >= outcome.first && hazard.injection <= outcome.last) own.push_back(hazard);
  }
  return own;
}

}  // namespace

SessionScore scoreSession(const std::string& log_path, const ScoreSettings& settings) {
  SessionScore score;
  score.header = session::readLogHeader(log_path);
  scoreHazards(log_path, settings, &score);
  AttemptCollector attempts(settings, score.header, answersTo(score.hazards));
  Scan(&attempts, settings.on_tick).read(log_path);
  for (const CollectedAttempt& attempt : attempts.take()) {
    score.attempts.push_back(scoreAttempt(attempt.outcome, attempt.motion.result(),
                                          compare(attempt.transits.transits(), settings.plan),
                                          hazardsIn(attempt.outcome, score.hazards), settings.standard));
    score.histories.push_back(attempt.history);
  }
  return score;
}

}  // namespace raven2_trainer::training
