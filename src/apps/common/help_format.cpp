#include "apps/common/help_format.h"

#include <cstdlib>
#include <sstream>
#include <vector>

namespace raven2_trainer::apps {
namespace {

constexpr std::size_t kColumn = 28;  // [characters] where descriptions begin
constexpr std::size_t kWidth = 72;   // [characters] of a description: 100 columns in all
constexpr double kNoLimit = 1e15;    // a larger upper limit does not help a reader
constexpr std::size_t kMostExcluded = 3;

/** CLI11 joins the type and the checks' descriptions by colons: "FLOAT:FLOAT in [0 - 1]", "TEXT:{on,off}". */
std::vector<std::string> partsOf(const CLI::Option& option) {
  std::vector<std::string> parts;
  std::istringstream all(option.get_type_name());
  for (std::string part; std::getline(all, part, ':');) parts.push_back(part);
  return parts;
}

std::string choicesOf(const std::string& part) {
  if (part.size() < 2 || part.front() != '{') return "";
  std::string words = part.substr(1, part.size() - 2);
  for (char& letter : words) {
    if (letter == ',') letter = '|';
  }
  return words;
}

std::string valueOf(const CLI::Option& option) {
  const std::vector<std::string> parts = partsOf(option);
  if (parts.empty()) return "";
  for (const std::string& part : parts) {
    if (const std::string choices = choicesOf(part); !choices.empty()) return choices;
    if (part == "IPV4") return "ADDRESS";
  }
  const std::string& type = parts.front();
  return type == "FLOAT" || type == "INT" || type == "UINT" ? "N" : type;
}

std::string rangeOf(const CLI::Option& option) {
  for (const std::string& part : partsOf(option)) {
    const std::size_t begin = part.find(" in ["), middle = part.find(" - ");
    if (begin == std::string::npos || middle == std::string::npos) continue;
    const std::string least = part.substr(begin + 5, middle - begin - 5);
    const std::string most = part.substr(middle + 3, part.size() - middle - 4);
    return std::strtod(most.c_str(), nullptr) > kNoLimit ? least + " or more" : least + " to " + most;
  }
  return "";
}

std::string namesOf(const std::set<CLI::Option*>& options) {
  std::string names;
  for (const CLI::Option* option : options) names += (names.empty() ? "" : ", ") + option->get_name();
  return names;
}

/** Options that it refuses, but for those that list it among many others: they say it once for all. */
std::set<CLI::Option*> excludedBy(const CLI::Option& option) {
  std::set<CLI::Option*> excluded;
  for (CLI::Option* each : option.get_excludes())
    if (each->get_excludes().size() <= kMostExcluded || option.get_excludes().size() > kMostExcluded)
      excluded.insert(each);
  return excluded;
}

/** "(0 to 86400; default 30; only with --replay)", or nothing. */
std::string notesOf(const CLI::Option& option) {
  std::vector<std::string> notes;
  if (const std::string range = rangeOf(option); !range.empty()) notes.push_back(range);
  if (!option.get_default_str().empty()) notes.push_back("default " + option.get_default_str());
  if (!option.get_needs().empty()) notes.push_back("only with " + namesOf(option.get_needs()));
  if (const auto excluded = excludedBy(option); !excluded.empty()) notes.push_back("not with " + namesOf(excluded));
  if (option.get_required() && !option.get_positional()) notes.emplace_back("required");
  std::string text;
  for (const std::string& note : notes) text += (text.empty() ? " (" : "; ") + note;
  return text.empty() ? text : text + ")";
}

std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string lines;
  std::size_t length = 0;
  for (std::string word; words >> word; length += word.size()) {
    if (length > 0 && length + 1 + word.size() > kWidth) {
      lines += '\n';
      length = 0;
    } else if (length > 0) {
      lines += ' ';
      ++length;
    }
    lines += word;
  }
  return lines;
}

}  // namespace

HelpFormat::HelpFormat() {
  column_width(kColumn);
  label("Positionals", "Arguments");
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  const bool takes_value = option->get_type_size() != 0 && !option->get_positional();
  if (!takes_value) return "";
  const std::string value = valueOf(*option);
  return (value.empty() ? "" : " " + value) + (option->get_expected_max() > 1 ? " ..." : "");
}

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  return wrapped(option->get_description() + notesOf(*option));
}

}  // namespace raven2_trainer::apps
