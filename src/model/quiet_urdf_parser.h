#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>

namespace raven2_trainer::model {

/**
 * urdf::parseURDF() without its console output: its error messages come back in `*errors`, joined by "; ". It skips
 * some elements that it cannot read and goes on, so a file is good only without errors. Null if it gave up. It sees '_'
 * for every '%' and '&'. Not thread-safe (the library's log handler is global); for set-up only.
 */
urdf::ModelInterfaceSharedPtr parseQuietly(const std::string& text, std::string* errors);

}  // namespace raven2_trainer::model
