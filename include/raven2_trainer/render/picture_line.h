#pragma once

#include <deque>

#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/**
 * The way of the pictures to the surgeon's eyes, with what faults of the video do on it (DaemonFaults::picture and
 * picture_delay_ms): black, frozen, the eyes swapped, late. Goes by the states' ticks alone, so that a log gives
 * the pictures that were seen live at the same rate. Keeps the states of the last 5 s, about 1 MB.
 */
class PictureLine {
 public:
  /**
   * @param[in] newest the states of now, no older than those before; older ones begin a new line.
   * @return those to draw for the surgeon, valid until the next call. While the picture is frozen, those of the last
   * one, its tick and time included; if a delay grows, no picture is older than the one before: it stays until
   * the delay has gone by. Whether they replace the real camera is always the present state: that line
   * is about the shown picture, and no part of a camera's view.
   */
  const Snapshot& pass(const Snapshot& newest);

 private:
  void keep(const Snapshot& newest);
  const Snapshot& newestBefore(Tick tick) const noexcept;

  std::deque<Snapshot> kept_;
  Snapshot seen_;
  bool has_seen_{false};
};

/** From where a state is seen by a camera (model::cameraAt); an eye of a pair from where the other is, if they are
 * swapped. */
model::Camera cameraSeeing(const Snapshot& snapshot,
                           const CameraConfig& camera,
                           const PerArm<Pose>& X_WB,
                           int width,
                           int height);

}  // namespace raven2_trainer::render
