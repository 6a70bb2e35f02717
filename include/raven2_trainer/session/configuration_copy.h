#pragma once

#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

/**
 * Copies a session's configuration files to `configuration/` in its directory. Relative paths between the copies are
 * those between the originals, so that the copies can be loaded. About 1 MB with the packaged meshes.
 * @param[in] files root file first; a path given twice is copied once. The result has the same order.
 * @param[in] overridden by path: text to write instead of the file's (TrainerConfig::overridden), so that the copies
 * contain the values that the session used.
 * @param[in] places by path: place of the copy of a file from another folder (TrainerConfig::urdf_places and their
 * meshes). The other files keep their places.
 * @throw SessionException if a file cannot be read or written.
 */
std::vector<ConfigurationFile> copyConfiguration(const SessionPaths& paths,
                                                 const std::vector<std::string>& files,
                                                 const std::map<std::string, std::string>& overridden = {},
                                                 const std::map<std::string, std::string>& places = {});

/**
 * Compares the copies with the hashes in the log's header.
 * @return path of the root file's copy.
 * @throw SessionException naming every file that is missing or differs, or if the session has no copies.
 */
std::string checkConfiguration(const SessionPaths& paths, const LogHeader& header);

}  // namespace raven2_trainer::session
