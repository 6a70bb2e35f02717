#include "config/readers.h"

#include <algorithm>
#include <cctype>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

/** A name that ROS takes below any namespace; the nodes of other programs have theirs next to it. */
std::string readNamespace(Section& root, const std::string& key) {
  const std::string name = root.text(key);
  const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '/'; };
  const bool begins = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0;
  const bool ends = !name.empty() && name.back() != '/' && name.find("//") == std::string::npos;
  if (begins && ends && std::all_of(name.begin(), name.end(), isWord)) return name;
  throw ConfigException(root.where(key) + " is \"" + name +
                        "\", expected a ROS name: a letter, then letters, digits, _ and single /");
}

}  // namespace

void readCrtk(Section& root, CrtkConfig* c) {
  c->enabled = root.boolean("enabled");
  for (const Arm arm : kArms)
    at(c->names, arm) = readNamespace(root, name(arm));
  if (c->names[0] == c->names[1])
    throw ConfigException(root.where("green") + " is \"" + c->names[1] + "\", as is gold");
  c->dialect = static_cast<CrtkDialect>(root.choice("dialect", kCrtkDialectNames));
  c->period = root.number("period", 0.001, 1);
  c->state_period = root.number("state_period", 0.01, 60);
  c->max_speed = root.number("max_speed", 0.001, 1);
  c->max_turn_rate = root.number("max_turn_rate", 0.01, 20);
  c->max_step = root.number("max_step", 1e-4, 0.2);
  c->max_step_turn = root.number("max_step_turn", 0.001, 3);
  c->move_speed = root.number("move_speed", 0.001, c->max_speed);
  c->move_turn_rate = root.number("move_turn_rate", 0.01, c->max_turn_rate);
  c->twist_timeout = root.number("twist_timeout", 0.01, 600);
  c->release_after = root.number("release_after", 0, 3600);
  c->trim_time = root.number("trim_time", 0, 60);
}

}  // namespace raven2_trainer::config
