#pragma once

#include <string>

#include "raven2_trainer/core/scene_roles.h"

namespace raven2_trainer::config {

/**
 * One file of config/scenes: a URDF, relative to the file's folder, and what its parts are for. Every key must be
 * there; a mapping or list may be empty. Whether the links exist is checked by model::loadSceneModel.
 *
 *   title: TEXT
 *   urdf: ../../urdf/NAME.urdf
 *   objects:     free bodies, each {link, shape, inner_radius, bar_radius}; shape round, square (inner_radius is then
 *                half of the opening's edge) or solid, which has neither radius; [m] [0.0005, 0.05], [0.0002, 0.02]
 *   pegs:        {link, base_W, height, radius}; [m] [-1, 1], [0.001, 0.2], [0.0005, 0.05]
 *   wires:       {link, radius, line_W}; [m] [0.0002, 0.02]; 2 to 64 points, none twice in a row
 *   breakables:  a list of {link, force, moment, ticks}; [N] [0.1, 100], [Nm] [0.001, 10], [1 ms] [1, 1000]
 *   tissue:      a list of links
 *   points:      each [x, y, z], [m] [-1, 1]
 *   regions:     {low_W, high_W}; [m] [-1, 1], low below high
 *   parking:     true or false
 *
 * Names are of 1 to 32 letters a to z, digits and underscores.
 * @throw ConfigException with FILE:LINE for a missing or unknown key, a value out of its range, a link with two roles
 * of one kind, more parts than kMaxSceneBodies or kMaxSceneParts, or a URDF that is not there.
 */
SceneRoles loadScene(const std::string& path);

/** Of pegs, wires, links of tissue, points and regions, each. */
constexpr std::size_t kMaxSceneParts = 64;
constexpr std::size_t kMaxWirePoints = 64;

}  // namespace raven2_trainer::config
