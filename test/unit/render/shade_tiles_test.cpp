#include "render/shade_tiles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "render/projection.h"
#include "render/shadow_target.h"
#include "render_fixture.h"

namespace raven2_trainer::render {
namespace {

/** A camera's view of the ground, z = 0 with a step of 30 mm, by ray and plane; empty above the horizon. For either
 * size of the shadow map. */
class ShadeTilesTest : public ::testing::TestWithParam<int> {
 protected:
  ShadeTilesTest()
      : camera_(testCamera()),
        clip_from_world_(clipFromWorld(camera_)),
        shadow_clip_from_world_(shadowClipFromWorld(camera_)),
        depth_(kWidth * kHeight, 1.0F),
        places_(kWidth * kHeight, Eigen::Vector2f(9.0F, 9.0F)),
        map_(static_cast<std::size_t>(map_size_ * map_size_), 1.0F) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        see(x, y);
    }
    tiles_.setPicture(kWidth, kHeight, depth_, clip_from_world_, shadow_clip_from_world_,
                      3.0F * 2.0F / static_cast<float>(map_size_), map_);
  }

  /** Casts the ray of a pixel, counted from the bottom left. */
  void see(int x, int y) {
    const int row = kHeight - 1 - y;
    const Vector3 ray = camera_.X_WC.R * Vector3((x - camera_.cx) / camera_.fx, (row - camera_.cy) / camera_.fy, 1.0);
    const double height = x < kWidth / 2 ? 0.0 : 0.03;
    const double along = (height - camera_.X_WC.p.z()) / ray.z();
    if (along <= 0.0) return;
    const Vector3 p_W = camera_.X_WC.p + along * ray;
    const Eigen::Vector4f clip = clip_from_world_ * p_W.cast<float>().homogeneous();
    const std::size_t pixel = static_cast<std::size_t>(y * kWidth + x);
    depth_[pixel] = 0.5F + 0.5F * clip.z() / clip.w();
    places_[pixel] = (shadow_clip_from_world_ * p_W.cast<float>().homogeneous()).head<2>();
  }

  std::vector<bool> touchedPixels(const std::vector<float>& map) {
    std::vector<bool> pixels(kWidth * kHeight, false);
    for (const PixelRun& run : tiles_.touched(map)) {
      for (int y = run.bottom; y < run.top; ++y)
        std::fill_n(pixels.begin() + y * kWidth + run.left, run.right - run.left, true);
    }
    return pixels;
  }

  /** [texels] from a pixel's place on the map to the middle of a texel, the larger of both directions. */
  double distance(std::size_t pixel, int column, int row) const {
    const Eigen::Vector2f at = places_[pixel].cwiseMax(-1.0F).cwiseMin(1.0F);
    const Eigen::Vector2f place = 0.5F * static_cast<float>(map_size_) * (at + Eigen::Vector2f::Ones());
    return std::max(std::abs(place.x() - (static_cast<float>(column) + 0.5F)),
                    std::abs(place.y() - (static_cast<float>(row) + 0.5F)));
  }

  const int map_size_{GetParam()};
  model::Camera camera_;
  Eigen::Matrix4f clip_from_world_, shadow_clip_from_world_;
  std::vector<float> depth_;
  std::vector<Eigen::Vector2f> places_;  // of each pixel, in the light's clip space
  std::vector<float> map_;
  ShadeTiles tiles_{map_size_};
};

TEST_P(ShadeTilesTest, WhereNothingDiffersNothingIsTouched) {
  EXPECT_TRUE(tiles_.touched(map_).empty());
}

TEST_P(ShadeTilesTest, EveryPixelThatMayLookUpATexelThatDiffersIsTouchedAndFewOthers) {
  Random random(4);
  for (int run = 0; run < 20; ++run) {
    const auto anywhere = [&] { return static_cast<int>(random.uniform(0.2, 0.8) * map_size_); };
    const int column = anywhere(), row = anywhere();
    std::vector<float> map = map_;
    map[static_cast<std::size_t>(row * map_size_ + column)] = 0.3F;
    const std::vector<bool> touched = touchedPixels(map);
    double seen = 0.0;
    for (std::size_t pixel = 0; pixel < touched.size(); ++pixel) {
      const bool must_be = depth_[pixel] < 1.0F && distance(pixel, column, row) < 3.0;
      ASSERT_TRUE(touched[pixel] || !must_be) << run << ": " << pixel % kWidth << ", " << pixel / kWidth;
      seen += touched[pixel] ? 1.0 : 0.0;
    }
    EXPECT_LT(seen, 0.02 * kWidth * kHeight) << run;
  }
}

TEST_P(ShadeTilesTest, ThePartsOfAMapThatNothingLooksUpTouchNothing) {
  std::vector<float> map = map_;
  std::size_t unseen = 0;
  const int step = map_size_ / 16;
  for (int row = 0; row < map_size_; row += step) {
    for (int column = 0; column < map_size_; column += step) {
      double nearest = map_size_;
      for (std::size_t pixel = 0; pixel < depth_.size(); pixel += 3) {
        if (depth_[pixel] < 1.0F) nearest = std::min(nearest, distance(pixel, column, row));
      }
      if (nearest < 0.06 * map_size_) continue;  // may be within a tile, a cell and the margin
      map[static_cast<std::size_t>(row * map_size_ + column)] = 0.3F;
      ++unseen;
    }
  }
  ASSERT_GT(unseen, 10U);
  EXPECT_TRUE(tiles_.touched(map).empty());
}

INSTANTIATE_TEST_SUITE_P(Maps,
                         ShadeTilesTest,
                         ::testing::Values(ShadowTarget::sizeFor(269), ShadowTarget::sizeFor(270)));

}  // namespace
}  // namespace raven2_trainer::render
