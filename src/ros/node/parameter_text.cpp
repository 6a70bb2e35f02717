#include "ros/node/parameter_text.h"

#include <cstdio>
#include <cstdlib>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Value = XmlRpc::XmlRpcValue;

/** As few digits as give the same number. */
std::string numberText(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.15g", number);
  if (std::strtod(text, nullptr) != number) std::snprintf(text, sizeof(text), "%.17g", number);
  return text;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    char escaped[8];
    std::snprintf(escaped, sizeof(escaped), "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    const bool is_control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    if (c == '"' || c == '\\') out += '\\';
    out += is_control ? std::string(escaped) : std::string(1, c);
  }
  return out + '"';
}

std::string listText(Value& list, const std::string& source) {
  std::string out;
  for (int i = 0; i < list.size(); ++i)
    out += (i > 0 ? ", " : "") + parameterText(list[i], source);
  return "[" + out + "]";
}

std::string mappingText(Value& mapping, const std::string& source) {
  std::string out;
  for (auto& [key, member] : mapping)
    out += (out.empty() ? "" : ", ") + quoted(key) + ": " + parameterText(member, source);
  return "{" + out + "}";
}

void addTree(Value& tree, const std::string& key, const std::string& node, config::Overrides* overrides) {
  for (auto& [name, member] : tree) {
    const std::string path = key.empty() ? name : key + "/" + name;
    if (member.getType() == Value::TypeStruct) {
      addTree(member, path, node, overrides);
      continue;
    }
    const std::string source = "ROS parameter " + node + "/" + path;
    overrides->push_back({path, parameterText(member, source), source});
  }
}

}  // namespace

std::string parameterText(const Value& value, const std::string& source) {
  Value v = value;  // its readers are not const
  switch (v.getType()) {
    case Value::TypeBoolean:
      return static_cast<bool>(v) ? "true" : "false";
    case Value::TypeInt:
      return std::to_string(static_cast<int>(v));
    case Value::TypeDouble:
      return numberText(static_cast<double>(v));
    case Value::TypeString: {
      const std::string text = v;
      return !text.empty() && text.front() == '[' ? text : quoted(text);
    }
    case Value::TypeArray:
      return listText(v, source);
    case Value::TypeStruct:
      return mappingText(v, source);
    default:
      throw ConfigException(source + " is neither number, truth value, text, list nor mapping");
  }
}

config::Overrides parameterOverrides(const Value& tree, const std::string& node) {
  if (tree.getType() != Value::TypeStruct)
    throw ConfigException("ROS parameter " + node + " is a value; parameters below it, by their names, were expected");
  Value readable = tree;
  config::Overrides overrides;
  addTree(readable, "", node, &overrides);
  return overrides;
}

}  // namespace raven2_trainer::ros_bridge
