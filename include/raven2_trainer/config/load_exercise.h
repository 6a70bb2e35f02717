#pragma once

#include <string>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/scene_roles.h"

namespace raven2_trainer::config {

/**
 * One file of config/exercises. Keys, all demanded unless called optional:
 *
 *   name:        the file's name
 *   title, source: TEXT
 *   number:      [1, 10000] order in lists
 *   skills:      a list of texts
 *   scene:       file in config/scenes, without its ending
 *   time_limit:  [s] [1, 3600]; beyond it the attempt fails
 *   begin:       when the timer starts: {pedal: down}, {left: OBJECT, peg: PEG} or {until: [PREDICATE, ...]}
 *   sets:        names for lists of links, used in `watch`: of links, earlier sets, links_L, links_R (all links of an
 *                arm), jaws_L, jaws_R, objects
 *   tracks:      1 to 8 of {name, object (optional), after (optional: an earlier track), steps}; at most 48 steps, each
 *                {name, until: 1 to 4 PREDICATEs, dwell: [s] [0, 60]}
 *   watch:       at most 12 of {mistake, fails (optional: true), limit (optional: [0, 1000]; more fail the attempt, 0:
 *                no limit)}. wire_touch and collision also have a, b (a name or a list), force [N] [0, 100], gap [s]
 *                [0, 60].
 *                drop has grace [s] [0, 10]. break_off, out_of_order and wrong_arm have nothing more, and occur once
 *   targets:     pegs on which an object may be let go
 *   metrics:     scored ones, each {} or {limit: NUMBER}
 *   guide:       optional: {arm, from: begin, to: {place: POINT}}
 *   drill:       optional: {scenario, at: {step: [1, steps], delay: [s] [0, 600], jitter: [s] [0, 600]}, right, wrong:
 *                lists of pedal_up, hold_still, slow, retreat, stop, push_on, within: [s] [0.05, 60]}
 *   expert:      optional: a list of mappings whose first key is a verb
 *   clumsy:      optional: a mapping of mappings
 *
 * A PREDICATE is one of these, an object being the track's unless the predicate has `object: NAME`:
 *   held: ARM, held_alone: ARM       gold, green, any or both
 *   untouched, lifted, resting: true or false
 *   around: PEG, unthreaded: WIRE, along: WIRE with to: [-] [0.01, 1]
 *   at: POINT with within: [m] [0.0001, 1]
 *   tip_near: POINT with arm and within: [m] [0.0001, 1]; tip_inside, tip_outside: REGION with arm
 *   in_view: POINT with within: [-] [0.01, 1]; camera_near: POINT with within: [m] [0.001, 2]
 * and, except for true and false, `not: true`.
 *
 * Names are of 1 to 32 letters a to z, digits and underscores. Whether links exist is checked by the judge.
 * @throw ConfigException with FILE:LINE for a missing or unknown key, a value out of its range, and a name that the
 * scene does not know.
 */
Exercise loadExercise(const std::string& path, const SceneRoles& roles);

}  // namespace raven2_trainer::config
