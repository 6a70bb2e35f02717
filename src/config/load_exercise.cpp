#include "raven2_trainer/config/load_exercise.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "config/names.h"
#include "config/read_predicate.h"
#include "config/read_script.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"
#include "raven2_trainer/training/metric_names.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

using Sets = std::map<std::string, std::vector<std::string>>;

constexpr std::size_t kMostLinks = 64, kMostMetrics = 64, kMostSets = 32;

void refuse(bool wrong, const std::string& where, const std::string& why) {
  if (wrong) throw ConfigException(where + " " + why);
}

std::string readName(Section& section) {
  const std::string name = section.text("name");
  refuse(!isName(name), section.where("name"), "is no name: 1 to 32 letters a to z, digits or underscores");
  return name;
}

std::string words(Section& section, const char* key) {
  const std::string text = section.text(key);
  refuse(text.empty(), section.where(key), "is empty");
  return text;
}

void checkCount(const Section& section, const char* key, std::size_t count, std::size_t least, std::size_t most) {
  refuse(
      count < least || count > most, section.where(key),
      "has " + std::to_string(count) + " entries, expected " + std::to_string(least) + " to " + std::to_string(most));
}

/** Index of an earlier part of that name; the number of parts without one. */
template <typename Part>
std::size_t findNamed(const std::vector<Part>& parts, const std::string& name) {
  const auto found = std::find_if(parts.begin(), parts.end(), [&](const Part& part) { return part.name == name; });
  return static_cast<std::size_t>(found - parts.begin());
}

// ---- tracks

std::vector<ExerciseStep> readSteps(Section& track, const SceneRoles& roles, std::uint8_t object) {
  std::vector<Section> entries = track.list("steps");
  checkCount(track, "steps", entries.size(), 1, kMaxSteps);
  std::vector<ExerciseStep> steps;
  for (Section& entry : entries) {
    ExerciseStep step;
    step.name = readName(entry);
    refuse(findNamed(steps, step.name) < steps.size(), entry.where("name"), "is the name of an earlier step too");
    step.until = readPredicates(entry, "until", roles, object);
    step.dwell = entry.number("dwell", 0, 60);
    entry.finish();
    steps.push_back(step);
  }
  return steps;
}

ExerciseTrack readTrack(Section& entry, const SceneRoles& roles, const std::vector<ExerciseTrack>& earlier) {
  ExerciseTrack track;
  track.name = readName(entry);
  refuse(findNamed(earlier, track.name) < earlier.size(), entry.where("name"), "is the name of an earlier track too");
  if (entry.has("object")) track.object = readObject(entry, "object", roles);
  if (entry.has("after")) {
    const std::size_t after = findNamed(earlier, entry.text("after"));
    refuse(after == earlier.size(), entry.where("after"), "is no earlier track");
    track.after = static_cast<std::uint8_t>(after);
  }
  track.steps = readSteps(entry, roles, track.object);
  entry.finish();
  return track;
}

std::size_t stepCount(const Exercise& exercise) {
  std::size_t count = 0;
  for (const ExerciseTrack& track : exercise.tracks)
    count += track.steps.size();
  return count;
}

void readTracks(Section& root, const SceneRoles& roles, Exercise* exercise) {
  std::vector<Section> entries = root.list("tracks");
  checkCount(root, "tracks", entries.size(), 1, kMaxTracks);
  for (Section& entry : entries)
    exercise->tracks.push_back(readTrack(entry, roles, exercise->tracks));
  const std::size_t count = stepCount(*exercise);
  refuse(count > kMaxSteps, root.where("tracks"),
         "have " + std::to_string(count) + " steps together, expected at most " + std::to_string(kMaxSteps));
}

void readBegin(Section& root, const SceneRoles& roles, Exercise* exercise) {
  Section begin = root.section("begin");
  if (begin.has("until")) {
    exercise->begin = readPredicates(begin, "until", roles, kNobody);
  } else if (begin.has("left")) {
    Predicate left;
    left.kind = PredicateKind::kAround;
    left.negated = 1;
    left.object = readObject(begin, "left", roles);
    left.place = readPeg(begin, "peg", roles);
    exercise->begin.push_back(left);
  } else {
    begin.text("pedal", {"down"});
  }
  begin.finish();
}

// ---- what counts as a mistake

void append(const std::vector<std::string>& more, std::vector<std::string>* links) {
  for (const std::string& link : more) {
    if (std::find(links->begin(), links->end(), link) == links->end()) links->push_back(link);
  }
}

Sets builtInSets(const SceneRoles& roles) {
  Sets sets;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    const std::string ending = kArmLinkEndings[arm];
    for (std::size_t k = 0; k < kArmLinkStems.size(); ++k) {
      const std::string link = kArmLinkStems[k] + ending;
      sets["links" + ending].push_back(link);
      if (k + 2 >= kArmLinkStems.size()) sets["jaws" + ending].push_back(link);
    }
  }
  std::vector<std::string>& objects = sets["objects"];
  for (const SceneObject& object : roles.objects)
    objects.push_back(object.link);
  return sets;
}

/** Links that the names of sets and links under `where` stand for. */
std::vector<std::string> linksOf(const std::vector<std::string>& names, const Sets& sets, const std::string& where) {
  std::vector<std::string> links;
  refuse(names.empty(), where, "is empty");
  for (std::size_t i = 0; i < names.size() && links.size() <= kMostLinks; ++i) {
    const auto set = sets.find(names[i]);
    append(set != sets.end() ? set->second : std::vector<std::string>{names[i]}, &links);
  }
  refuse(links.size() > kMostLinks, where, "stands for more than " + std::to_string(kMostLinks) + " links");
  refuse(links.empty(), where, "stands for no link");
  return links;
}

Sets readSets(Section& root, const SceneRoles& roles) {
  Sets sets = builtInSets(roles);
  Section entries = root.section("sets");
  checkCount(root, "sets", entries.keys().size(), 0, kMostSets);
  for (const std::string& name : entries.keys()) {
    refuse(!isName(name), entries.where(name), "is no name: 1 to 32 letters a to z, digits or underscores");
    refuse(sets.count(name) != 0, entries.where(name), "is a set that there is without being said");
    sets[name] = linksOf(entries.texts(name), sets, entries.where(name));
  }
  entries.finish();
  return sets;
}

std::vector<std::string> readParty(Section& entry, const char* key, const Sets& sets) {
  const std::vector<std::string> names =
      entry.isList(key) ? entry.texts(key) : std::vector<std::string>{entry.text(key)};
  return linksOf(names, sets, entry.where(key));
}

bool isTouch(Mistake mistake) {
  return mistake == Mistake::kWireTouch || mistake == Mistake::kCollision;
}

WatchRule readRule(Section& entry, const Sets& sets) {
  WatchRule rule;
  rule.mistake = static_cast<Mistake>(entry.choice("mistake", kMistakeNames));
  if (isTouch(rule.mistake)) {
    rule.names_a = readParty(entry, "a", sets);
    rule.names_b = readParty(entry, "b", sets);
    rule.place_a = entry.where("a");
    rule.place_b = entry.where("b");
    rule.force = entry.number("force", 0, 100);
    rule.gap = entry.number("gap", 0, 60);
  }
  if (rule.mistake == Mistake::kDrop) rule.grace = entry.number("grace", 0, 10);
  if (entry.has("fails")) rule.fails = entry.boolean("fails") ? 1 : 0;
  if (entry.has("limit")) rule.limit = static_cast<std::uint32_t>(entry.integer("limit", 0, 1000));
  entry.finish();
  return rule;
}

void readWatch(Section& root, const SceneRoles& roles, Exercise* exercise) {
  const Sets sets = readSets(root, roles);
  std::vector<Section> entries = root.list("watch");
  checkCount(root, "watch", entries.size(), 0, kMaxWatchRules);
  for (Section& entry : entries) {
    const WatchRule rule = readRule(entry, sets);
    const auto is_same = [&](const WatchRule& other) { return other.mistake == rule.mistake; };
    const bool is_there = std::any_of(exercise->rules.begin(), exercise->rules.end(), is_same);
    refuse(!isTouch(rule.mistake) && is_there, entry.where("mistake"), "is watched for already");
    refuse(rule.mistake == Mistake::kBreakOff && roles.breakables.empty(), entry.where("mistake"),
           "can never come: nothing of scene " + roles.name + " breaks off");
    exercise->rules.push_back(rule);
  }
  exercise->targets = readPegs(root, "targets", roles);
}

// ---- scores, guide, drill

std::vector<std::string> metricNames() {
  std::vector<std::string> names;
  for (const MetricInfo& metric : kMetrics)
    names.emplace_back(metric.name);
  return names;
}

void readMetrics(Section& root, Exercise* exercise) {
  Section entries = root.section("metrics");
  checkCount(root, "metrics", entries.keys().size(), 0, kMostMetrics);
  for (const std::string& name : entries.keys()) {
    refuse(findMetric(name) == nullptr, entries.where(name), "is no metric" + expectedOneOf(name, metricNames()));
    Section entry = entries.section(name);
    ScoredMetric metric;
    metric.name = name;
    metric.place = entries.where(name);
    if (entry.has("limit")) {
      metric.has_limit = 1;
      metric.limit = entry.number("limit", metric.name == kForceAbove ? 0.0 : -1e6, 1e6);
    }
    entry.finish();
    exercise->metrics.push_back(metric);
  }
  entries.finish();
}

void readGuide(Section& root, const SceneRoles& roles, Exercise* exercise) {
  if (!root.has("guide")) return;
  Section guide = root.section("guide");
  exercise->guide.given = 1;
  exercise->guide.arm = kArms[guide.choice("arm", kArmNames)];
  guide.text("from", {"begin"});
  Section to = guide.section("to");
  exercise->guide.point = readPoint(to, "place", roles);
  to.finish();
  guide.finish();
}

std::vector<DrillResponse> readResponses(Section& drill, const char* key) {
  std::vector<DrillResponse> responses;
  for (const std::string& name : drill.texts(key)) {
    const auto found = std::find(kDrillResponseNames.begin(), kDrillResponseNames.end(), name);
    refuse(found == kDrillResponseNames.end(), drill.where(key),
           "holds \"" + name.substr(0, 80) + "\"" +
               expectedOneOf(name, {kDrillResponseNames.begin(), kDrillResponseNames.end()}));
    const auto response = static_cast<DrillResponse>(found - kDrillResponseNames.begin());
    const bool is_twice = std::find(responses.begin(), responses.end(), response) != responses.end();
    refuse(is_twice, drill.where(key), "names " + name + " twice");
    responses.push_back(response);
  }
  return responses;
}

void readDrill(Section& root, Exercise* exercise) {
  if (!root.has("drill")) return;
  Section drill = root.section("drill");
  ExerciseDrill& d = exercise->drill;
  d.scenario = words(drill, "scenario");
  Section at = drill.section("at");
  d.step = static_cast<std::uint32_t>(at.integer("step", 1, static_cast<std::int64_t>(stepCount(*exercise))));
  d.delay = at.number("delay", 0, 600);
  d.jitter = at.number("jitter", 0, 600);
  at.finish();
  d.right = readResponses(drill, "right");
  d.wrong = readResponses(drill, "wrong");
  d.within = drill.number("within", 0.05, 60);
  refuse(d.right.empty(), drill.where("right"), "is empty");
  for (const DrillResponse response : d.right) {
    const bool is_both = std::find(d.wrong.begin(), d.wrong.end(), response) != d.wrong.end();
    refuse(is_both, drill.where("wrong"),
           std::string("holds ") + kDrillResponseNames[static_cast<std::size_t>(response)] + ", which is right");
  }
  drill.finish();
}

}  // namespace

Exercise loadExercise(const std::string& path, const SceneRoles& roles) {
  Section root = Section::fromFile(path);
  Exercise exercise;
  exercise.file = path;
  exercise.name = readName(root);
  refuse(exercise.name != fs::path(path).stem(), root.where("name"), "is not the file's name");
  exercise.title = words(root, "title");
  exercise.source = words(root, "source");
  exercise.number = static_cast<std::uint32_t>(root.integer("number", 1, 10000));
  exercise.skills = root.texts("skills");
  exercise.scene = root.text("scene");
  refuse(exercise.scene != roles.name, root.where("scene"),
         "is \"" + exercise.scene.substr(0, 80) + "\", and the scene at hand is " + roles.name);
  exercise.time_limit = root.number("time_limit", 1, 3600);
  readBegin(root, roles, &exercise);
  readTracks(root, roles, &exercise);
  readWatch(root, roles, &exercise);
  readMetrics(root, &exercise);
  readGuide(root, roles, &exercise);
  readDrill(root, &exercise);
  readScripts(root, &exercise);
  root.finish();
  return exercise;
}

}  // namespace raven2_trainer::config
