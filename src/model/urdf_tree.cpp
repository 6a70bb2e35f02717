#include "model/urdf_tree.h"

#include <set>

namespace raven2_trainer::model {
namespace {

struct JointEnds {
  std::string name, parent, child;
  int line{};
};

class TreeReader {
 public:
  TreeReader(const std::vector<XmlElement>& elements, const std::string& file) : elements_(elements), file_(file) {}

  UrdfTree read() {
    if (elements_.front().tag != "robot") fail(elements_.front().line, "root element is not <robot>");
    tree_.robot_line = elements_.front().line;
    for (std::size_t i = 1; i < elements_.size(); ++i)
      readElement(i);
    if (tree_.link_lines.empty()) fail(tree_.robot_line, "robot without links");
    checkJoints();
    visit(root());
    checkAllReached();
    return std::move(tree_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const { failAt(file_, line, what); }

  void readElement(std::size_t i) {
    const XmlElement& element = elements_[i];
    if (element.parent != 0 || (element.tag != "link" && element.tag != "joint")) return;
    const bool is_link = element.tag == "link";
    if (element.name.empty()) fail(element.line, "<" + element.tag + "> without a name");
    auto& lines = is_link ? tree_.link_lines : tree_.joint_lines;
    if (!lines.emplace(element.name, element.line).second) {
      fail(element.line,
           element.tag + " '" + element.name + "' is already on line " + std::to_string(lines[element.name]));
    }
    if (is_link) {
      file_order_.push_back(element.name);
    } else {
      joints_.push_back({element.name, childName(i, "parent"), childName(i, "child"), element.line});
    }
  }

  std::string childName(std::size_t element, const char* tag) const {
    for (std::size_t i = element + 1; i < elements_.size(); ++i) {
      if (elements_[i].parent == static_cast<int>(element) && elements_[i].tag == tag) return elements_[i].name;
    }
    return {};
  }

  void checkJoints() {
    for (const JointEnds& joint : joints_) {
      for (const auto& [what, link] : {std::pair{"parent", joint.parent}, std::pair{"child", joint.child}}) {
        if (tree_.link_lines.count(link) == 0) {
          fail(joint.line, "joint '" + joint.name + "': unknown " + what + " link '" + link + "'");
        }
      }
      if (!parent_joint_.emplace(joint.child, joint.name).second) {
        fail(joint.line, "joint '" + joint.name + "': link '" + joint.child + "' already hangs on joint '" +
                             parent_joint_[joint.child] + "', a loop");
      }
    }
  }

  std::string root() const {
    std::string root;
    for (const std::string& link : file_order_) {
      if (parent_joint_.count(link) != 0) continue;
      if (!root.empty()) {
        fail(tree_.link_lines.at(link), "link '" + link + "' has no parent joint, nor has '" + root + "'");
      }
      root = link;
    }
    if (root.empty()) fail(tree_.link_lines.at(file_order_.front()), "no root: the joints form a loop");
    return root;
  }

  void visit(const std::string& root) {
    std::vector<std::string> waiting{root};
    while (!waiting.empty()) {
      const std::string link = waiting.back();
      waiting.pop_back();
      tree_.links.push_back(link);
      for (auto joint = joints_.rbegin(); joint != joints_.rend(); ++joint) {
        if (joint->parent == link) waiting.push_back(joint->child);
      }
    }
  }

  void checkAllReached() const {
    const std::set<std::string> reached(tree_.links.begin(), tree_.links.end());
    for (const std::string& link : file_order_) {
      if (reached.count(link) == 0) fail(tree_.link_lines.at(link), "link '" + link + "' is part of a loop of joints");
    }
  }

  const std::vector<XmlElement>& elements_;
  const std::string& file_;
  UrdfTree tree_;
  std::vector<std::string> file_order_;
  std::vector<JointEnds> joints_;
  std::map<std::string, std::string> parent_joint_;  // by child link
};

}  // namespace

int UrdfTree::lineOf(const std::string& message) const {
  for (const auto* lines : {&joint_lines, &link_lines}) {
    for (const auto& [name, line] : *lines) {
      if (message.find('[' + name + ']') != std::string::npos ||
          message.find('\'' + name + '\'') != std::string::npos) {
        return line;
      }
    }
  }
  return robot_line;
}

UrdfTree readTree(const std::vector<XmlElement>& elements, const std::string& file) {
  return TreeReader(elements, file).read();
}

}  // namespace raven2_trainer::model
