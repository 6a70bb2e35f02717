#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "raven2_trainer/config/overrides.h"
#include "raven2_trainer/core/types.h"

namespace YAML {
class Node;
}

namespace raven2_trainer::config {

/**
 * One mapping of a YAML file, read key by key. Every getter demands its key and checks type and range; finish()
 * refuses keys that nobody asked for. All throw ConfigException: FILE:LINE: key, value, what is allowed.
 */
class Section {
 public:
  /** Parses a file of at most 1 MiB whose root is a mapping; nesting to 64, 20,000 values, no aliases, no tags. */
  static Section fromFile(const std::string& path);
  /** The same from a text; `name` stands for the file in messages. */
  static Section fromText(const std::string& text, const std::string& name);

  bool has(const std::string& key) const;
  /** Kind of the value, if there is one. Asking does not count as reading. */
  bool isList(const std::string& key) const;
  bool isMapping(const std::string& key) const;
  /** All keys in the file's order; those not read later are still refused by finish(). */
  std::vector<std::string> keys() const;
  Section section(const std::string& key);
  std::vector<Section> list(const std::string& key);
  double number(const std::string& key, double low, double high);
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high);
  bool boolean(const std::string& key);
  /** Any text; or one of `allowed` if that is not empty. */
  std::string text(const std::string& key, const std::vector<std::string>& allowed = {});
  std::vector<std::string> texts(const std::string& key);
  Vec3 vec3(const std::string& key, double low, double high);
  JointArray joints(const std::string& key, double low, double high);
  /** A list of `least` to `most` points. */
  std::vector<Vec3> points(const std::string& key, std::size_t least, std::size_t most, double low, double high);

  /** Position of a text in a list of names. */
  template <std::size_t N>
  std::size_t choice(const std::string& key, const std::array<const char*, N>& names) {
    return choiceOf(key, std::vector<std::string>(names.begin(), names.end()));
  }

  /** Copies of this mapping, one for each element of the list under `key`, with the element in the list's place; one
   *  equal copy without a list. */
  std::vector<Section> alternatives(const std::string& key) const;
  /** A copy with `text` under `key`. */
  Section with(const std::string& key, const std::string& text) const;

  /** Puts a value where it belongs, below this mapping; a key that is not there is put, too, and refused by finish().
   *  Messages about it begin with its source instead of FILE:LINE. Before anything is read. */
  void put(const Override& override);
  /** The mapping as YAML, without its comments. */
  std::string yaml() const;

  /** Throws for the first key that was not read. */
  void finish() const;

  /** "FILE:LINE: key" for messages about something read from here. */
  std::string where(const std::string& key) const;
  const std::string& file() const { return file_; }

 private:
  Section(const YAML::Node& node, std::string file, std::string path);
  Section with(const std::string& key, const YAML::Node& value) const;
  /** "FILE:LINE: ", or the source of what was put there, above or below: "SOURCE: ". */
  std::string placeOf(const std::string& key, const std::string& otherwise) const;
  std::string missing(const std::string& key) const;
  YAML::Node find(const std::string& key);
  std::size_t choiceOf(const std::string& key, const std::vector<std::string>& names);
  template <typename Array>
  Array numbers(const std::string& key, double low, double high);

  std::shared_ptr<YAML::Node> node_;
  std::string file_, path_;
  std::string place_;  ///< "FILE:LINE: " of the mapping: a copy's node has no place
  std::set<std::string> read_;
  std::shared_ptr<std::map<std::string, std::string>> sources_;  ///< of what was put, by its path in the file
};

}  // namespace raven2_trainer::config
