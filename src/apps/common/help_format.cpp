#include "apps/common/help_format.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <utility>
#include <vector>

namespace raven2_trainer::apps {
namespace {

constexpr std::size_t kColumn = 28;  // [characters] where descriptions begin
constexpr std::size_t kWidth = 72;   // [characters] of a description: 100 columns in all
constexpr double kNoLimit = 1e15;    // a larger upper limit does not help a reader
constexpr std::size_t kMostExcluded = 3;

/** A number without an exponent; other text as it is. */
std::string plain(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || text.find('e') == std::string::npos || std::abs(value) > kNoLimit)
    return text;
  std::array<char, 40> fixed{};
  std::snprintf(fixed.data(), fixed.size(), "%.9f", value);
  std::string digits = fixed.data();
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return digits;
}

/** Of a list without CLI11's brackets. */
std::string defaultOf(const CLI::Option& option) {
  const std::string text = option.get_default_str();
  const bool is_list = text.size() >= 2 && text.front() == '[' && text.back() == ']';
  return plain(is_list ? text.substr(1, text.size() - 2) : text);
}

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
  if (type == "FLOAT" || type == "INT" || type == "UINT") return "N";
  return type == "TEXT" ? "NAME" : type;
}

std::string rangeOf(const CLI::Option& option) {
  for (const std::string& part : partsOf(option)) {
    const std::size_t begin = part.find(" in ["), middle = part.find(" - ");
    if (begin == std::string::npos || middle == std::string::npos) continue;
    const std::string least = plain(part.substr(begin + 5, middle - begin - 5));
    const std::string most = plain(part.substr(middle + 3, part.size() - middle - 4));
    return std::strtod(most.c_str(), nullptr) > kNoLimit ? least + " or more" : least + " to " + most;
  }
  return "";
}

std::string namesOf(const std::set<CLI::Option*>& options) {
  std::string names;
  for (const CLI::Option* option : options) names += (names.empty() ? "" : ", ") + option->get_name();
  return names;
}

/** Options that it refuses. One that refuses many says so in its description, for them, too. */
std::set<CLI::Option*> excludedBy(const CLI::Option& option) {
  std::set<CLI::Option*> excluded;
  if (option.get_excludes().size() > kMostExcluded) return excluded;
  for (CLI::Option* each : option.get_excludes())
    if (each->get_excludes().size() <= kMostExcluded) excluded.insert(each);
  return excluded;
}

/** "(0 to 86400; default 30; only with --replay)", or nothing. */
std::string notesOf(const CLI::Option& option) {
  std::vector<std::string> notes;
  if (const std::string range = rangeOf(option); !range.empty()) notes.push_back(range);
  if (!option.get_default_str().empty()) notes.push_back("default " + defaultOf(option));
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

std::string HelpFormat::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const {
  const auto block = [&](const std::string& group) {
    const auto options = app->get_options(
        [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
    return options.empty() ? std::string() : make_group(group, false, options);
  };
  std::string groups;
  for (const std::string& group : app->get_groups()) {
    if (!group.empty() && group != kPorts && group != kIgnored) groups += block(group);
  }
  return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) + groups + block(kPorts) +
         block(kIgnored) + "\n" + make_footer(app);
}

/** CLI11 adds "{false}" to a flag that clears. */
std::string HelpFormat::make_option_name(const CLI::Option* option, bool is_positional) const {
  const std::string name = CLI::Formatter::make_option_name(option, is_positional);
  return name.substr(0, name.find('{'));
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
