#pragma once

#include <Eigen/Core>

#include "raven2_trainer/model/camera.h"

namespace raven2_trainer::render {

/** Clip space from W for a camera; depth 5 mm to 10 m. A point lands on the pixel that Camera::project gives. */
Eigen::Matrix4f clipFromWorld(const model::Camera& camera);

/** [m] Along the view direction, from the depth buffer's number below 1. */
float metresOf(float depth) noexcept;

/** Unit direction in W toward the key light: above, from the surgeon's left. */
Eigen::Vector3f keyLight();

/** Unit direction in W toward the fill light: low, from the right. */
Eigen::Vector3f fillLight();

/** Clip space of the key light about what the camera looks at: the nearer, the finer. Depends on the camera alone, so
 *  that shadows do not swim. */
Eigen::Matrix4f shadowClipFromWorld(const model::Camera& camera);

/** Clip space (-1..1) to texture coordinates (0..1). */
Eigen::Matrix4f textureFromClip();

/** M to W. */
Eigen::Matrix4f matrixOf(const Pose& pose);

/** False for a pose or colour with NaN, infinity, or a position beyond 1 km: such things are not drawn. */
bool isDrawable(const Pose& pose) noexcept;

/** False if a sphere lies wholly outside the camera's pyramid. */
bool isInView(const model::Camera& camera, const Vector3& centre_W, double radius) noexcept;

/** False if neither a sphere nor anything that it can shade from the key light is in view. */
bool isShadowInView(const model::Camera& camera, const Vector3& centre_W, double radius) noexcept;

/** False if a sphere lies wholly outside the space that the key light's clip space holds. */
bool isInShadowMap(const Eigen::Matrix4f& shadow_clip_from_world, const Vector3& centre_W, double radius) noexcept;

}  // namespace raven2_trainer::render
