#pragma once

#include <string>
#include <vector>

// Folders of configuration: what is in them is known by the name of its file.

namespace raven2_trainer::config {

/** Of the .yaml files in a folder, without the ending, sorted; empty if there is no such folder. */
std::vector<std::string> namesIn(const std::string& folder);

/**
 * The file of that name. Only names of the folder's files are looked for, so none leads out of it.
 * @param[in] what For the message: "exercise".
 * @param[in] also words that the caller accepts instead of a name, for the message.
 * @param[in] place Where the name was read: "exercise.yaml:7: scene"; empty: a command line.
 * @throw ConfigException naming all that are known.
 */
std::string namedFile(const std::string& folder,
                      const std::string& name,
                      const char* what,
                      const std::vector<std::string>& also,
                      const std::string& place = "");

}  // namespace raven2_trainer::config
