#include "raven2_trainer/training/session_score.h"

#include <deque>

#include "raven2_trainer/training/session_metrics.h"
#include "training/attempt_collector.h"
#include "training/hazard_collector.h"

namespace raven2_trainer::training {

namespace {

/** Records that other threads wrote may stand before the tick they belong to: they wait for it. */
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

/** The second reading of a log. */
class Scan {
 public:
  Scan(const ScoreSettings& settings, const session::LogHeader& header, const SessionMetrics& metrics)
      : attempts_(settings, header), hazards_(settings, metrics), on_tick_(settings.on_tick) {}

  void read(const std::string& log_path) {
    session::LogVisitor visitor;
    visitor.tick = [this](const TickRecord& record) { add(record); };
    visitor.request = [this](const RequestRecord& record) { hazards_.add(record); };
    visitor.exercise = [this](const ExerciseRecord& record) { attempts_.add(record); };
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

  std::vector<CollectedAttempt> attempts() { return attempts_.take(); }
  std::vector<HazardScore> hazards() { return hazards_.take(); }
  std::uint64_t hazardsBeyond() const { return hazards_.beyond(); }

 private:
  void add(const TickRecord& record) {
    if (on_tick_) on_tick_();
    attempts_.add(record);
    hazards_.add(record);
    now_ = record.model.tick;
    release();
  }

  void release() {
    const auto use = [this](Tick tick, const auto& record) {
      attempts_.addLater(tick, record);
      hazards_.addLater(tick, record);
    };
    forces_.release(now_, use);
    contacts_.release(now_, use);
  }

  AttemptCollector attempts_;
  HazardCollector hazards_;
  Waiting<HapticRecord> forces_;
  Waiting<ContactRecord> contacts_;
  std::function<void()> on_tick_;
  Tick now_{-1};
};

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
  Scan scan(settings, score.header, computeMetrics(log_path, settings.on_tick));
  scan.read(log_path);
  score.hazards = scan.hazards();
  score.hazards_beyond = scan.hazardsBeyond();
  for (const CollectedAttempt& attempt : scan.attempts()) {
    score.attempts.push_back(scoreAttempt(attempt.outcome, attempt.motion.result(),
                                          compare(attempt.transits.transits(), settings.plan),
                                          hazardsIn(attempt.outcome, score.hazards), settings.standard));
    score.histories.push_back(attempt.history);
  }
  return score;
}

}  // namespace raven2_trainer::training
