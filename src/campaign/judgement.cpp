#include "raven2_trainer/campaign/judgement.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "campaign/csv_row.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNamedRuns = 5;  // of each thing that is wrong

std::string keyOf(const Campaign& campaign, const CampaignRun& run) {
  return campaign.experiments[run.experiment].name + "/" + kPhaseNames[static_cast<std::size_t>(run.phase)];
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool isAllowed(const Explanations& explanations, const std::string& key, const std::string& outcome) {
  const auto found = explanations.find(key);
  return found != explanations.end() && holds(found->second.allowed, outcome);
}

Explanation readExplanation(config::Section section) {
  Explanation explanation{section.texts("allowed"), section.text("why")};
  for (const std::string& outcome : explanation.allowed) {
    if (!isOutcome(outcome))
      throw ConfigException(section.where("allowed") + " holds \"" + outcome + "\", which is no outcome");
  }
  section.finish();
  return explanation;
}

std::string line(const std::string& what, const std::vector<std::uint32_t>& runs) {
  if (runs.empty()) return "";
  std::string text = std::to_string(runs.size()) + " runs " + what + ":";
  for (std::size_t i = 0; i < std::min(kNamedRuns, runs.size()); ++i)
    text += " " + std::to_string(runs[i]);
  return text + (runs.size() > kNamedRuns ? " ...\n" : "\n");
}

bool isMaskedAlone(const std::vector<std::string>& outcomes) {
  return outcomes.size() == 1 && outcomes.front() == "masked";
}

/** Of one scenario in one phase. */
struct Entry {
  bool expects_masked{true};  ///< nothing but masked was published, or nothing was
  bool is_masked{true};       ///< every run
};

}  // namespace

std::string explanationsOf(const std::string& campaign_file) {
  const fs::path file(campaign_file);
  return (file.parent_path() / (file.stem().string() + "_explained.yaml")).string();
}

Explanations loadExplanations(const std::string& path, const Campaign& campaign) {
  if (!fs::exists(path)) return {};
  std::set<std::string> known;
  for (const CampaignRun& run : campaign.runs)
    known.insert(keyOf(campaign, run));
  config::Section root = config::Section::fromFile(path);
  Explanations explanations;
  for (const std::string& key : root.keys()) {
    if (known.count(key) == 0)
      throw ConfigException(root.where(key) + " explains a scenario and phase that the campaign has not");
    explanations[key] = readExplanation(root.section(key));
  }
  return explanations;
}

void keepExplanations(const Campaign& campaign, const OutputPaths& paths) {
  const std::string kept = paths.explanations(campaign.name), given = explanationsOf(campaign.file);
  std::error_code none;
  if (fs::equivalent(given, kept, none)) return;  // the output is written next to the campaign
  fs::remove(kept);
  if (fs::exists(given)) fs::copy_file(given, kept);
}

Judgement judge(const Campaign& campaign,
                const Explanations& explanations,
                const std::map<std::uint32_t, std::string>& rows) {
  Judgement judgement;
  std::map<std::string, Entry> entries;
  for (const auto& [number, row] : rows) {
    const CampaignRun& run = campaign.runs.at(number - 1);
    const std::vector<std::string>& published = campaign.experiments[run.experiment].published;
    const std::string outcome = outcomeOf(row), key = keyOf(campaign, run);
    Entry& entry = entries[key];
    entry.is_masked = entry.is_masked && outcome == "masked";
    entry.expects_masked = entry.expects_masked && (published.empty() || isMaskedAlone(published));
    if (neverActed(row)) judgement.never_acted.push_back(number);
    if (!hasOutcome(row)) {
      judgement.without_outcome.push_back(number);
    } else if (!published.empty() && !holds(published, outcome) && !isAllowed(explanations, key, outcome)) {
      judgement.unexplained[key + ": " + outcome].push_back(number);
    }
  }
  const bool is_whole = rows.size() == campaign.runs.size();  // a shard may hold those that are masked alone
  for (const auto& [key, entry] : entries) {
    const auto found = explanations.find(key);
    const bool is_explained = found != explanations.end() && isMaskedAlone(found->second.allowed);
    if (entry.is_masked && !entry.expects_masked && !is_explained && is_whole) judgement.inert.push_back(key);
  }
  return judgement;
}

std::string inWords(const Judgement& judgement) {
  std::string text = line("in which the fault never acted", judgement.never_acted) +
                     line("without an outcome", judgement.without_outcome);
  for (const std::string& key : judgement.inert)
    text += "every run masked, though more is expected: " + key + "\n";
  for (const auto& [what, runs] : judgement.unexplained)
    text += line("neither as published nor explained, " + what, runs);
  return text;
}

}  // namespace raven2_trainer::campaign
