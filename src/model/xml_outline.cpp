#include "model/xml_outline.h"

#include <algorithm>
#include <string_view>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/shown.h"

namespace raven2_trainer::model {
namespace {

constexpr std::size_t kMaxDepth = 64;        // the URDF parser recurses
constexpr std::size_t kMaxElements = 20000;  // the larger of the files in urdf/ has 800
constexpr std::size_t kMostOfAReason = 600;  // a few lines of a screen
constexpr const char* kSpace = " \t\r\n";

/** What the URDF parser would take for more than a part of a name or a number (xml_outline.h). */
constexpr std::string_view kNotInTags("%&\0", 3);

class Outliner {
 public:
  Outliner(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  std::vector<XmlElement> run() {
    while (skipTo('<'))
      readMarkup();
    if (!open_.empty()) {
      const XmlElement& last = elements_[static_cast<std::size_t>(open_.back())];
      failAt(file_, last.line, "element <" + last.tag + "> is not closed");
    }
    if (elements_.empty()) fail("no XML element");
    return std::move(elements_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { failAt(file_, line_, what); }

  bool startsWith(const char* prefix) const { return text_.compare(at_, std::string(prefix).size(), prefix) == 0; }

  void advanceTo(std::size_t end) {
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
    at_ = end;
  }

  bool skipTo(char c) {
    const std::size_t next = text_.find(c, at_);
    advanceTo(next == std::string::npos ? text_.size() : next);
    return next != std::string::npos;
  }

  void skipPast(const char* end, const char* what) {
    const std::size_t next = text_.find(end, at_);
    if (next == std::string::npos) fail(std::string(what) + " is not closed");
    advanceTo(next + std::string(end).size());
  }

  void readMarkup() {
    if (startsWith("<!--")) return skipPast("-->", "comment");
    if (startsWith("<?")) return skipPast("?>", "processing instruction");
    if (startsWith("<!")) return skipPast(">", "declaration");
    if (startsWith("</")) return readEnd();
    readStart();
  }

  void readEnd() {
    const std::size_t end = text_.find('>', at_);
    if (end == std::string::npos) fail("tag is not closed");
    std::string tag = text_.substr(at_ + 2, end - at_ - 2);
    tag.erase(std::min(tag.find_last_not_of(kSpace) + 1, tag.size()));
    if (open_.empty() || elements_[static_cast<std::size_t>(open_.back())].tag != tag) {
      fail("</" + tag + "> closes an element that is not open");
    }
    open_.pop_back();
    advanceTo(end + 1);
  }

  void readStart() {
    const std::size_t end = tagEnd();
    const std::string inside = text_.substr(at_ + 1, end - at_ - 1);
    XmlElement element;
    element.tag = inside.substr(0, inside.find_first_of(" \t\r\n/"));
    if (element.tag.empty()) fail("tag without a name");
    if (inside.find_first_of(kNotInTags) != std::string::npos) {
      fail("<" + element.tag + "> holds '%', '&' or a zero byte, which no tag may");
    }
    if (open_.empty() && !elements_.empty()) fail("second root element <" + element.tag + ">");
    element.line = line_;
    element.name = attribute(inside, element.tag == "parent" || element.tag == "child" ? "link" : "name");
    element.parent = open_.empty() ? -1 : open_.back();
    if (open_.size() >= kMaxDepth) fail("elements nested deeper than " + std::to_string(kMaxDepth));
    if (elements_.size() >= kMaxElements) fail("more than " + std::to_string(kMaxElements) + " elements");
    if (inside.back() != '/') open_.push_back(static_cast<int>(elements_.size()));
    elements_.push_back(element);
    advanceTo(end + 1);
  }

  /** Position of the tag's '>', outside quotes. */
  std::size_t tagEnd() const {
    char quote = 0;
    for (std::size_t i = at_ + 1; i < text_.size(); ++i) {
      const char c = text_[i];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '>') {
        return i;
      } else if (c == '<') {
        break;
      }
    }
    fail("tag is not closed");
  }

  static std::string attribute(const std::string& inside, const std::string& key) {
    for (std::size_t at = inside.find(key); at != std::string::npos; at = inside.find(key, at + 1)) {
      if (at == 0 || std::string(kSpace).find(inside[at - 1]) == std::string::npos) continue;
      const std::size_t equals = inside.find_first_not_of(kSpace, at + key.size());
      if (equals == std::string::npos || inside[equals] != '=') continue;
      const std::size_t open = inside.find_first_not_of(kSpace, equals + 1);
      if (open == std::string::npos) return {};
      const std::size_t close = inside.find(inside[open], open + 1);
      return close == std::string::npos ? std::string{} : inside.substr(open + 1, close - open - 1);
    }
    return {};
  }

  const std::string& text_;
  const std::string& file_;
  std::size_t at_{0};
  int line_{1};
  std::vector<XmlElement> elements_;
  std::vector<int> open_;
};

}  // namespace

std::vector<XmlElement> outlineXml(const std::string& text, const std::string& file) {
  return Outliner(text, file).run();
}

void failAt(const std::string& file, int line, const std::string& what) {
  throw ModelException(file + ":" + std::to_string(line) + ": " + shown(what, kMostOfAReason));
}

}  // namespace raven2_trainer::model
