#pragma once

#include <functional>
#include <string>

namespace raven2_trainer::session {

/**
 * Writes ticks.csv, one row a tick and arm, columns:
 * `tick,t_s,arm,mode,runlevel,pedal,q1..q7,dq1..dq7,tau1..tau7,rq1..rq7,rdq1..rdq7,px,py,pz,rpx,rpy,rpz,fx,fy,fz,
 * fault` (51). Ticks count from the first pedal-down (`tick` is ModelState::session_tick; earlier ticks are left out).
 * Model values are those after the tick. Robot values are those that the tick read, empty before the first frame. The
 * force, in frame B, is from the newest haptic record up to that tick (0 before the first). `fault` is the scenario's
 * name, or empty.
 * @param[in] progress called repeatedly with 0..1; may be empty.
 * @return rows written.
 * @throw SessionException.
 */
std::size_t exportTicksCsv(const std::string& log_path,
                           const std::string& csv_path,
                           const std::function<void(double)>& progress);

}  // namespace raven2_trainer::session
