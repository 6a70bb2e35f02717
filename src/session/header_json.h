#pragma once

#include <string>

#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

/** The first record: format version, the header's fields and the schema of every record. */
std::string headerToJson(const LogHeader& header);

/**
 * The reverse, schema left out. @throw std::exception with the reason if the text is not such a header, or if its
 * records are laid out in another way than ours.
 */
LogHeader headerFromJson(const std::string& text);

}  // namespace raven2_trainer::session
