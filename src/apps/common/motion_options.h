#pragma once

#include <fstream>
#include <string>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/console/truth_log.h"

namespace CLI {
class App;
}

namespace raven2_trainer::apps {

/** The simulated surgeon and its record: add() registers the options, choice() reads them. */
struct MotionOptions {
  std::string motion{"scripted"};
  std::string reaction{"none"};  ///< [ms], or "none"
  std::string truth;             ///< file; empty: no file

  void add(CLI::App* app);
  /** @throw ConfigException. */
  console::MotionChoice choice() const;
};

/** The simulated surgeon's own record of its actions, as a file. */
class TruthFile {
 public:
  /** @param[in] path Empty: no file. @throw ConfigException if it cannot be written. */
  explicit TruthFile(const std::string& path);

  /** For makeMotion(); null if there is no file. */
  console::TruthLog* log() noexcept { return path_.empty() ? nullptr : &log_; }

  /** Call after the motion. @throw ConfigException. */
  void write();

 private:
  std::string path_;
  std::ofstream stream_;
  console::TruthLog log_;
};

}  // namespace raven2_trainer::apps
