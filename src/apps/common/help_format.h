#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace raven2_trainer::apps {

// Groups of options that few users need. --help prints them last.
constexpr const char* kPorts = "Network ports";
constexpr const char* kIgnored = "Accepted, without effect here";

/**
 * Prints --help in words: `--duration N   Session time [s] (0 to 86400; default 30)` in place of CLI11's
 * `--duration FLOAT:FLOAT in [0 - 86400]=30`. Shows choices as the value: `--homing full|quick`.
 */
class HelpFormat : public CLI::Formatter {
 public:
  HelpFormat();
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace raven2_trainer::apps
