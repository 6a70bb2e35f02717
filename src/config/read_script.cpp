#include "config/read_script.h"

#include <cmath>
#include <cstdlib>

#include "config/names.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

constexpr std::size_t kMostVerbs = 64, kMostHands = 16, kMostValues = 32;

/** A plain decimal number. */
bool toNumber(const std::string& text, double* number) {
  if (text.find_first_not_of("+-.0123456789eE") != std::string::npos) return false;
  char* end = nullptr;
  *number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(*number);
}

ScriptValue readList(Section& section, const std::string& key) {
  ScriptValue value;
  bool are_numbers = true;
  for (const std::string& word : section.texts(key)) {
    double number = 0.0;
    are_numbers = are_numbers && toNumber(word, &number);
    value.numbers.push_back(number);
    value.text += (value.text.empty() ? "" : " ") + word;
  }
  if (!are_numbers) value.numbers.clear();
  return value;
}

ScriptValue readScalar(Section& section, const std::string& key) {
  ScriptValue value;
  value.text = section.text(key);
  double number = 0.0;
  if (toNumber(value.text, &number)) value.numbers.push_back(number);
  return value;
}

/** All values of a mapping, those of mappings in it behind the mapping's key. */
void readValues(Section& section, const std::string& prefix, std::vector<ScriptValue>* values) {
  for (const std::string& key : section.keys()) {
    if (section.isMapping(key)) {
      Section inner = section.section(key);
      readValues(inner, prefix + key + "/", values);
    } else {
      values->push_back(section.isList(key) ? readList(section, key) : readScalar(section, key));
      values->back().key = prefix + key;
    }
    if (values->size() > kMostValues)
      throw ConfigException(section.where(key) + " is one of more than " + std::to_string(kMostValues) + " values");
  }
  section.finish();
}

std::string placeOf(const Section& section) {
  return section.where("");
}

void readExpert(Section& root, Exercise* exercise) {
  std::vector<Section> entries = root.list("expert");
  checkCount(root, "expert", entries.size(), kMostVerbs);
  for (Section& entry : entries) {
    ScriptVerb verb;
    verb.place = placeOf(entry);
    if (entry.keys().empty()) throw ConfigException(verb.place + " is empty, expected a verb");
    verb.verb = entry.keys().front();
    readValues(entry, "", &verb.values);
    exercise->expert.push_back(verb);
  }
}

void readClumsy(Section& root, Exercise* exercise) {
  Section hands = root.section("clumsy");
  checkCount(root, "clumsy", hands.keys().size(), kMostHands);
  for (const std::string& name : hands.keys()) {
    Section entry = hands.section(name);
    ClumsyHand hand;
    hand.name = name;
    hand.place = placeOf(entry);
    readValues(entry, "", &hand.values);
    exercise->clumsy.push_back(hand);
  }
}

}  // namespace

void readScripts(Section& root, Exercise* exercise) {
  if (root.has("expert")) readExpert(root, exercise);
  if (root.has("clumsy")) readClumsy(root, exercise);
}

}  // namespace raven2_trainer::config
