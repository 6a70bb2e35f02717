#include "config/readers.h"

#include <algorithm>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

std::uint16_t port(Section& section, const std::string& key, int low) {
  return static_cast<std::uint16_t>(section.integer(key, low, 65535));
}

void readItpRules(Section& root, ItpRules* c) {
  c->hardened = root.text("ingest", {"hardened", "compat"}) == "hardened";
  c->auth = static_cast<ItpAuth>(root.choice("auth", kItpAuthNames));
  c->max_increment_um = static_cast<std::int32_t>(root.integer("max_increment_um", 1, 1000000));
  c->max_rotation = root.number("max_rotation", 0.001, kPi);
  c->max_rate = root.number("max_rate", 1, 1e6);
  c->max_burst = static_cast<std::int32_t>(root.integer("max_burst", 1, 10000));
  c->master_timeout = root.number("master_timeout", 0.02, 60);
  c->compat_timeout = root.number("compat_timeout", 0.02, 60);
}

/** Numbers of 127.0.0.0/8, or "localhost". A name such as 127.example.org may be that of any interface. */
bool isLoopback(const std::string& address) {
  const bool is_numeric = address.find_first_not_of("0123456789.") == std::string::npos;
  return address == "localhost" || (is_numeric && address.rfind("127.", 0) == 0);
}

/** Every computer that reaches a port for plain ITP can move the arms: beyond this computer only on request. */
void checkExposure(const Section& root, const NetworkConfig& c) {
  if (c.itp.auth != ItpAuth::kOff && c.key_file.empty()) {
    throw ConfigException(root.where("auth") + " asks for signatures, but key_file is empty");
  }
  if (c.itp.auth != ItpAuth::kOff && !c.itp.hardened) {
    throw ConfigException(root.where("auth") + " asks for signatures, which ingest: compat does not verify");
  }
  if (isLoopback(c.bind_address) || c.itp.auth == ItpAuth::kRequired || c.allow_plaintext_remote) return;
  throw ConfigException(root.where("bind_address") + " is \"" + c.bind_address +
                        "\", beyond this computer, and unsigned ITP is taken: set auth: required and a key_file, or "
                        "allow_plaintext_remote: true if every computer that reaches the port may move the arms");
}

constexpr double kLastFelt = 0.05;   // [s] age of a state by which no force comes from it any more
constexpr double kAgeError = 0.004;  // [s] by which a state may be older than it is taken for (wire::FrameDelay)

/** Longest [s] a state may count as fresh: then a tick passes, the force falls, and a tick passes before it is sent. */
double longestFresh(const HapticGains& haptics) {
  return kLastFelt - kAgeError - haptics.max_force / haptics.max_slew - 2.0 * kTickSeconds;
}

/** No two pedals may share a button. */
void readJoy(Section& joy, JoyConfig* c) {
  c->topic = joy.text("topic");
  c->timeout = joy.number("timeout", 0.05, 60);
  for (std::size_t i = 0; i < kPedalCount; ++i) {
    c->buttons[i] = static_cast<int>(joy.integer(kPedalNames[i], -1, 127));
    const auto before = c->buttons.begin() + static_cast<std::ptrdiff_t>(i);
    const auto same = std::find(c->buttons.begin(), before, c->buttons[i]);
    if (c->buttons[i] < 0 || same == before) continue;
    throw ConfigException(joy.where(kPedalNames[i]) + " is button " + std::to_string(c->buttons[i]) + ", as is " +
                          kPedalNames[static_cast<std::size_t>(same - c->buttons.begin())]);
  }
  joy.finish();
}

}  // namespace

void readNetwork(Section& root, const HapticGains& haptics, NetworkConfig* c) {
  c->bind_address = root.text("bind_address");
  c->master_port = port(root, "master_port", 0);
  c->daemon_host = root.text("daemon_host");
  c->robot_host = root.text("robot_host");
  c->robot_port = port(root, "robot_port", 1);
  c->console_host = root.text("console_host");
  c->force_port = port(root, "force_port", 1);
  c->sight = root.boolean("sight");
  c->sight_port = port(root, "sight_port", 1);
  c->state_port = port(root, "state_port", 1);
  c->stale_after = root.number("stale_after", 0.002, longestFresh(haptics));
  c->reconnect_min = root.number("reconnect_min", 0.01, 5);
  c->reconnect_max = root.number("reconnect_max", std::max(0.1, c->reconnect_min), 60);
  readItpRules(root, &c->itp);
  c->master_address = root.text("master_address");
  c->allow_plaintext_remote = root.boolean("allow_plaintext_remote");
  c->key_file = root.text("key_file");
  c->stream = root.text("stream");
  if (c->stream != "none" && c->itp.auth != ItpAuth::kOff)
    throw ConfigException(root.where("stream") + " is \"" + c->stream +
                          "\", but what is signed is proper ITP (auth): none, or auth: off");
  if (!c->key_file.empty()) c->key_file = (fs::absolute(root.file()).parent_path() / c->key_file).string();
  checkExposure(root, *c);
  Section joy = root.section("joy");
  readJoy(joy, &c->joy);
}

}  // namespace raven2_trainer::config
