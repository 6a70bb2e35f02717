#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::model {

/** A start tag of an XML file. */
struct XmlElement {
  std::string tag;
  std::string name;  ///< attribute `name`, or `link` of <parent> and <child>; empty if neither
  int line{};
  int parent{-1};  ///< index of the enclosing element
};

/**
 * The tags of an XML text with their line numbers, which the URDF parser does not keep. Checks that tags are closed
 * in order, because that parser's message for a broken file has no line either.
 * @throw ModelException FILE:LINE: for text that is not well-formed, and for a tag with '%', '&' or a zero byte.
 * urdfdom 3.0 gives unreadable text to printf as the format. So "%s" for a number reads memory that is not
 * there; with '&' a '%' can be written; a zero ends the text for some functions and not for others.
 */
std::vector<XmlElement> outlineXml(const std::string& text, const std::string& file);

/** Throws ModelException("FILE:LINE: what"), of `what` as much as is shown(). */
[[noreturn]] void failAt(const std::string& file, int line, const std::string& what);

}  // namespace raven2_trainer::model
