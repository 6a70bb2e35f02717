#include "raven2_trainer/config/section.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "config/yaml_guard.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"
#include "raven2_trainer/core/shown.h"

namespace raven2_trainer::config {
namespace {

constexpr std::size_t kMaxFileSize = 1U << 20U;

std::string place(const std::string& file, const YAML::Mark& mark) {
  return file + ":" + std::to_string(mark.is_null() ? 1 : mark.line + 1) + ": ";
}

std::string readFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw ConfigException(path + ":1: cannot be opened");
  std::string text(kMaxFileSize + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxFileSize) throw ConfigException(path + ":1: larger than 1 MiB");
  return text;
}

std::string print(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string shown(const std::string& text) {
  constexpr std::size_t kMost = 80;  // a line of a screen
  return raven2_trainer::shown(text, kMost);
}

double toNumber(const YAML::Node& node, const std::string& where, double low, double high) {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value)) {
    throw ConfigException(where + " is not a number");
  }
  if (!(value >= low && value <= high)) {
    throw ConfigException(where + " is " + print(value) + ", expected [" + print(low) + ", " + print(high) + "]");
  }
  return value;
}

template <typename Array>
Array toNumbers(const YAML::Node& node, const std::string& where, double low, double high) {
  Array values{};
  if (!node.IsSequence() || node.size() != values.size()) {
    throw ConfigException(where + " is not a list of " + std::to_string(values.size()) + " numbers");
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = toNumber(node[i], where + "[" + std::to_string(i) + "]", low, high);
  return values;
}

YAML::Node parse(const std::string& text, const std::string& name) {
  try {
    checkYaml(text, name);
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw ConfigException(place(name, e.mark) + shown(e.msg));
  }
}

/** The mapping below a key, made if it is missing. */
YAML::Node mappingIn(YAML::Node mapping, const std::string& key, const std::string& source) {
  YAML::Node below = mapping[key];
  if (!below.IsDefined()) below = YAML::Node(YAML::NodeType::Map);
  if (!below.IsMap()) throw ConfigException(source + ": " + shown(key) + " is not a mapping");
  return below;
}

/** Not the emitter's own way with a node, which writes out the parser's tags of quoted texts. */
void emit(const YAML::Node& node, YAML::Emitter* out) {
  if (node.IsMap()) {
    *out << YAML::BeginMap;
    for (const auto& entry : node) {
      *out << YAML::Key << entry.first.Scalar() << YAML::Value;
      emit(entry.second, out);
    }
    *out << YAML::EndMap;
  } else if (node.IsSequence()) {
    const bool is_plain = std::all_of(node.begin(), node.end(), [](const auto& each) { return each.IsScalar(); });
    *out << (is_plain ? YAML::Flow : YAML::Block) << YAML::BeginSeq;
    for (const auto& each : node)
      emit(each, out);
    *out << YAML::EndSeq;
  } else if (node.IsNull()) {
    *out << YAML::Null;
  } else {
    *out << node.Scalar();
  }
}

}  // namespace

Section::Section(const YAML::Node& node, std::string file, std::string path)
    : node_(std::make_shared<YAML::Node>(node)),
      file_(std::move(file)),
      path_(std::move(path)),
      place_(place(file_, node.Mark())),
      sources_(std::make_shared<std::map<std::string, std::string>>()) {
  std::set<std::string> keys;
  for (const auto& entry : node) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    if (!keys.insert(key).second)
      throw ConfigException(place(file_, entry.first.Mark()) + path_ + shown(key) + " is given twice");
  }
}

Section Section::fromFile(const std::string& path) {
  return fromText(readFile(path), path);
}

Section Section::fromText(const std::string& text, const std::string& name) {
  const YAML::Node node = parse(text, name);
  if (!node.IsMap()) throw ConfigException(name + ":1: expected a mapping of keys to values");
  return {node, name, ""};
}

std::string Section::where(const std::string& key) const {
  const YAML::Node value = (*node_)[key];
  const bool has_line = value.IsDefined() && !value.Mark().is_null();
  return placeOf(key, has_line ? place(file_, value.Mark()) : place_) + path_ + shown(key);
}

std::string Section::placeOf(const std::string& key, const std::string& otherwise) const {
  const std::string path = path_ + key;
  const auto leads_to = [](const std::string& above, const std::string& below) {
    const bool begins = below.compare(0, above.size(), above) == 0;
    return begins && (below.size() == above.size() || below[above.size()] == '/' || below[above.size()] == '[');
  };
  for (const auto& [put, source] : *sources_) {
    if (leads_to(put, path) || leads_to(path, put)) return source + ": ";
  }
  return otherwise;
}

YAML::Node Section::find(const std::string& key) {
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined() || value.IsNull()) throw ConfigException(missing(key));
  read_.insert(key);
  return value;
}

bool Section::has(const std::string& key) const {
  return (*node_)[key].IsDefined();
}

bool Section::isList(const std::string& key) const {
  return has(key) && (*node_)[key].IsSequence();
}

bool Section::isMapping(const std::string& key) const {
  return has(key) && (*node_)[key].IsMap();
}

std::vector<std::string> Section::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : *node_)
    names.push_back(entry.first.IsScalar() ? entry.first.Scalar() : "");
  return names;
}

Section Section::section(const std::string& key) {
  const YAML::Node value = find(key);
  if (!value.IsMap()) throw ConfigException(where(key) + " is not a mapping");
  Section section(value, file_, path_ + shown(key) + "/");
  section.sources_ = sources_;
  return section;
}

std::vector<Section> Section::list(const std::string& key) {
  const YAML::Node value = find(key);
  if (!value.IsSequence()) throw ConfigException(where(key) + " is not a list");
  std::vector<Section> sections;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value[i].IsMap()) throw ConfigException(where(key) + " holds an entry that is not a mapping");
    sections.push_back(Section(value[i], file_, path_ + key + "[" + std::to_string(i) + "]/"));
    sections.back().sources_ = sources_;
  }
  return sections;
}

double Section::number(const std::string& key, double low, double high) {
  return toNumber(find(key), where(key), low, high);
}

std::int64_t Section::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const double value = number(key, static_cast<double>(low), static_cast<double>(high));
  if (value != std::floor(value))
    throw ConfigException(where(key) + " is " + print(value) + ", expected a whole number");
  return static_cast<std::int64_t>(value);
}

bool Section::boolean(const std::string& key) {
  const YAML::Node node = find(key);
  bool value = false;
  if (!YAML::convert<bool>::decode(node, value)) throw ConfigException(where(key) + " is not true or false");
  return value;
}

std::string Section::text(const std::string& key, const std::vector<std::string>& allowed) {
  const YAML::Node node = find(key);
  if (!node.IsScalar()) throw ConfigException(where(key) + " is not a text");
  if (!allowed.empty() && std::find(allowed.begin(), allowed.end(), node.Scalar()) == allowed.end()) {
    throw ConfigException(where(key) + " is \"" + shown(node.Scalar()) + "\"" + expectedOneOf(node.Scalar(), allowed));
  }
  return node.Scalar();
}

std::vector<std::string> Section::texts(const std::string& key) {
  const YAML::Node node = find(key);
  if (!node.IsSequence()) throw ConfigException(where(key) + " is not a list");
  std::vector<std::string> words;
  for (const YAML::Node& word : node) {
    if (!word.IsScalar()) throw ConfigException(where(key) + " holds an entry that is not a text");
    words.push_back(word.Scalar());
  }
  return words;
}

template <typename Array>
Array Section::numbers(const std::string& key, double low, double high) {
  return toNumbers<Array>(find(key), where(key), low, high);
}

Vec3 Section::vec3(const std::string& key, double low, double high) {
  return numbers<Vec3>(key, low, high);
}

JointArray Section::joints(const std::string& key, double low, double high) {
  return numbers<JointArray>(key, low, high);
}

std::vector<Vec3> Section::points(const std::string& key,
                                  std::size_t least,
                                  std::size_t most,
                                  double low,
                                  double high) {
  const YAML::Node node = find(key);
  if (!node.IsSequence() || node.size() < least || node.size() > most) {
    throw ConfigException(where(key) + " is not a list of " + std::to_string(least) + " to " + std::to_string(most) +
                          " points");
  }
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < node.size(); ++i)
    points.push_back(toNumbers<Vec3>(node[i], where(key) + "[" + std::to_string(i) + "]", low, high));
  return points;
}

std::size_t Section::choiceOf(const std::string& key, const std::vector<std::string>& names) {
  const std::string word = text(key, names);
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), word) - names.begin());
}

Section Section::with(const std::string& key, const YAML::Node& value) const {
  YAML::Node copy(YAML::NodeType::Map);  // never assign to an element: both mappings share it
  for (const auto& entry : *node_) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) copy.force_insert(entry.first, entry.second);
  }
  copy.force_insert(key, value);
  Section section(copy, file_, path_);
  section.place_ = place_;
  section.sources_ = sources_;
  return section;
}

Section Section::with(const std::string& key, const std::string& text) const {
  return with(key, YAML::Node(text));
}

std::vector<Section> Section::alternatives(const std::string& key) const {
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined() || !value.IsSequence()) return {*this};
  if (value.size() == 0) throw ConfigException(where(key) + " is an empty list");
  std::vector<Section> sections;
  for (const YAML::Node& element : value)
    sections.push_back(with(key, element));
  return sections;
}

void Section::put(const Override& override) {
  if (override.value.size() > kMaxFileSize) throw ConfigException(override.source + ": larger than 1 MiB");
  YAML::Node mapping = *node_;
  std::size_t begin = 0;
  for (std::size_t slash = 0; (slash = override.key.find('/', begin)) != std::string::npos; begin = slash + 1)
    mapping.reset(mappingIn(mapping, override.key.substr(begin, slash - begin), override.source));
  mapping[override.key.substr(begin)] = parse(override.value, override.source);
  (*sources_)[path_ + override.key] = override.source;
}

std::string Section::yaml() const {
  YAML::Emitter out;
  emit(*node_, &out);
  return std::string(out.c_str()) + "\n";
}

/** An unread key that is one mistake away is taken for it. With two mistakes it may be another key: robot_port for
 *  robot_host. */
std::string Section::missing(const std::string& key) const {
  for (const auto& entry : *node_) {
    const std::string each = entry.first.IsScalar() ? entry.first.Scalar() : "";
    const std::string hint = didYouMean(each, {key}, 1);
    if (each == key || read_.count(each) > 0 || hint.empty()) continue;
    return placeOf(each, place(file_, entry.first.Mark())) + "unknown key " + path_ + shown(each) + hint + " (" + key +
           " is missing)";
  }
  return where(key) + " is missing";
}

void Section::finish() const {
  for (const auto& entry : *node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (read_.count(key) == 0)
      throw ConfigException(placeOf(key, place(file_, entry.first.Mark())) + "unknown key " + path_ + shown(key) +
                            didYouMean(key, {read_.begin(), read_.end()}));
  }
}

}  // namespace raven2_trainer::config
