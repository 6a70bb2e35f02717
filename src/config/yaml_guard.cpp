#include "config/yaml_guard.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

constexpr std::size_t kMaxDepth = 64;      // the files of config/ go 4 deep
constexpr std::size_t kMaxValues = 20000;  // they hold some 200 each; a value costs the parser some 500 bytes

class Guard : public YAML::EventHandler {
 public:
  explicit Guard(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(mark, "a second document; one is expected");
  }
  void OnDocumentEnd() override {}
  void OnAnchor(const YAML::Mark& mark, const std::string&) override { fail(mark, "anchors (&) are not allowed"); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { fail(mark, "aliases (*) are not allowed"); }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark, ""); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string&) override {
    count(mark, tag);
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string& tag,
                       YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    enter(mark, tag);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    enter(mark, tag);
  }
  void OnMapEnd() override { --depth_; }

 private:
  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw ConfigException(file_ + ":" + std::to_string(mark.is_null() ? 1 : mark.line + 1) + ": " + what);
  }

  void enter(const YAML::Mark& mark, const std::string& tag) {
    count(mark, tag);
    if (++depth_ > kMaxDepth) fail(mark, "nested deeper than " + std::to_string(kMaxDepth));
  }

  /** The parser's own tags: none, "?" for a plain value, "!" for a quoted one. */
  void count(const YAML::Mark& mark, const std::string& tag) {
    if (!tag.empty() && tag != "?" && tag != "!") fail(mark, "tags (!) are not allowed");
    if (++values_ > kMaxValues) fail(mark, "more than " + std::to_string(kMaxValues) + " values");
  }

  const std::string& file_;
  std::size_t documents_{0}, depth_{0}, values_{0};
};

}  // namespace

void checkYaml(const std::string& text, const std::string& file) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Guard guard(file);
  while (parser.HandleNextDocument(guard)) {
  }
}

}  // namespace raven2_trainer::config
