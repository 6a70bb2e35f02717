#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/xml_outline.h"

namespace raven2_trainer::model {

/** Links and joints of a URDF, their tree, and their lines in the file. */
struct UrdfTree {
  std::vector<std::string> links;  ///< parents before children
  std::map<std::string, int> link_lines;
  std::map<std::string, int> joint_lines;
  int robot_line{1};

  /** Line of the link or joint that a message of the URDF parser names, else of <robot>. */
  int lineOf(const std::string& message) const;
};

/**
 * Finds loops, double names, unknown links and several roots before the URDF parser sees them: it accepts some of
 * them silently and reports no line.
 * @throw ModelException FILE:LINE:.
 */
UrdfTree readTree(const std::vector<XmlElement>& elements, const std::string& file);

}  // namespace raven2_trainer::model
