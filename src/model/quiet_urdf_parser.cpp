#include "model/quiet_urdf_parser.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <exception>

namespace raven2_trainer::model {
namespace {

/** Collects the errors that urdfdom logs while it lives. */
class LogCatcher : public console_bridge::OutputHandler {
 public:
  LogCatcher() { console_bridge::useOutputHandler(this); }
  ~LogCatcher() override { console_bridge::restorePreviousOutputHandler(); }
  LogCatcher(const LogCatcher&) = delete;
  LogCatcher& operator=(const LogCatcher&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (!text_.empty()) text_ += "; ";
    text_ += text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/**
 * For urdfdom, whose messages are formats (xml_outline.h). Tags that hold any were refused; this holds also where the
 * two readers disagree about what is a tag and what a comment.
 */
std::string withoutFormats(std::string text) {
  std::replace(text.begin(), text.end(), '%', '_');
  std::replace(text.begin(), text.end(), '&', '_');
  return text;
}

}  // namespace

urdf::ModelInterfaceSharedPtr parseQuietly(const std::string& text, std::string* errors) {
  LogCatcher catcher;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(withoutFormats(text));
    *errors = catcher.text();
  } catch (const std::exception& e) {
    *errors = e.what();
  }
  return model;
}

}  // namespace raven2_trainer::model
