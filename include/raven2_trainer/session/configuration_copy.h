#pragma once

#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

/**
 * Copies the files that configure a session below its directory, in `configuration/`, each at the same place relative
 * to the others, so that the copies are read as the originals were. About 1 MB with the packaged meshes.
 * @param[in] files in the order wanted, the root file first; a path given twice is copied once.
 * @param[in] overridden texts that stand for some of them (TrainerConfig::overridden), so that what reads the copies
 * reads what ran.
 * @param[in] places Where files that are read from elsewhere would stand next to the others (TrainerConfig::urdf_places
 * and what belongs to them): there the copy has them. The others stand where they are.
 * @throw SessionException if one cannot be read or written.
 */
std::vector<ConfigurationFile> copyConfiguration(const SessionPaths& paths,
                                                 const std::vector<std::string>& files,
                                                 const std::map<std::string, std::string>& overridden = {},
                                                 const std::map<std::string, std::string>& places = {});

/**
 * Checks the copies against the hashes of the log's header.
 * @return path of the root file's copy.
 * @throw SessionException naming every file that is missing or differs, or if the session has no copies.
 */
std::string checkConfiguration(const SessionPaths& paths, const LogHeader& header);

}  // namespace raven2_trainer::session
