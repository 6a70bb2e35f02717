#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/daemon/live_pace.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/render/picture_line.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/render/tool_contacts.h"

namespace raven2_trainer {
struct TrainerConfig;
}

namespace raven2_trainer::daemon {

/** The pictures of a state: of the live camera, of both eyes of the stereo pair, of the second camera. */
enum class Viewpoint : std::uint8_t { kLive, kLeftEye, kRightEye, kSecond };
constexpr std::size_t kViewpointCount = 4;

/** A live picture, valid during the call that hands it out. */
struct LiveImage {
  const std::vector<std::uint8_t>& rgb;  ///< top row first
  const model::Camera& camera;
  Tick tick;             ///< of the model state drawn
  bool is_view;          ///< the present view (ModelState::view), or a substitute for the real camera, which is silent
  Viewpoint viewpoint;   ///< of camera
  std::int64_t time_ns;  ///< ModelState::time_ns of the shown state: for a frozen picture the old one
};
using ImageSink = std::function<void(const LiveImage&)>;

/** Body of the render thread. Its OpenGL context lives and dies on that thread: construct it there. */
class RenderLoop {
 public:
  using Clock = std::function<std::int64_t()>;  ///< [ns]

  /**
   * All but the sink and the clock must outlive it.
   * @param[in] body_names by the numbers of contacts. @param[in] clock by which frames are long, and the real camera is
   * silent. @throw RenderException.
   */
  RenderLoop(const TrainerConfig& config,
             const model::RavenModel& raven,
             const model::SceneModel& scene,
             const std::vector<std::string>& body_names,
             SharedState* shared,
             ImageSink sink,
             Clock clock = net::monotonicNow);
  /**
   * Draws the newest states, as far as faults of the video let them be seen, and hands the picture out. While somebody
   * looks at them (SharedState::pictures_watched), both eyes' pictures follow, and in one frame of kSecondEvery the
   * second camera's; if drawing is slow, once a second. Where a frame takes too long, the next ones are smaller or
   * fewer (LivePace); stderr and SharedState::live_picture say so. While no picture has a client, most calls only
   * follow the states, so that a picture does not depend on earlier clients: one call in kUnwatchedPeriod draws.
   */
  void frame();
  static constexpr double kUnwatchedPeriod = 1.0;  ///< [s] shows on /diagnostics that pictures still can be drawn
  static constexpr std::uint64_t kSecondEvery = 3;  ///< [frames] ours: 10 Hz are enough for the surroundings
  /** [s] from the beginning of a frame to that of the next. */
  double period() const noexcept { return pace_.period(); }

 private:
  /** Draws pictures of one size. */
  struct Stage {
    Stage(const TrainerConfig& config, const model::RavenModel& raven, const model::SceneModel& scene, double scale);
    render::Renderer renderer;
    render::SceneBuilder builder;
  };

  void hearOfPlans();
  bool isCameraSilent() const;
  bool isSecondDue(std::int64_t now) const noexcept;
  render::Snapshot newest();
  void drawAll(const render::Snapshot& seen, bool is_view, const WatchedPictures& wanted);
  void draw(const render::Scene& scene, const render::Snapshot& snapshot, Viewpoint viewpoint, bool is_view);
  void adapt(double busy, bool is_measure);
  void reportPace(bool has_changed);

  const TrainerConfig& config_;
  const model::RavenModel& raven_;
  const model::SceneModel& scene_;
  SharedState& shared_;
  ImageSink sink_;
  Clock clock_;
  const render::ToolContacts contacts_;
  const std::array<CameraConfig, kViewpointCount> cameras_;  // by Viewpoint
  render::PictureLine line_;
  LivePace pace_;
  std::optional<Stage> stage_;  // for pace_'s level; none: to be made for the next frame
  std::int64_t drawn_ns_{0};    // when the newest picture was begun
  std::int64_t second_ns_{0};   // the same of the second camera's
  double busy_{0.0};            // [s] that the newest frame without it took
  LivePicture live_;
  render::PlanNews plans_;
  std::uint64_t plan_heard_{0}, execution_heard_{0};  // versions of their cells
};

/**
 * All that the render thread does: frames, at the loop's pace, until it is asked to end. Whatever goes wrong there,
 * memory and who takes the pictures included, ends the live picture and nothing else: LivePicture::failed and stderr
 * say so.
 * @param[in] make constructs the loop, on this thread. @param[in] wait Waits so many seconds, zero included; true: end.
 */
void keepDrawing(const std::function<std::unique_ptr<RenderLoop>()>& make,
                 const std::function<bool(double)>& wait,
                 SharedState* shared) noexcept;

}  // namespace raven2_trainer::daemon
