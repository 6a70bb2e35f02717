#include "raven2_trainer/render/renderer.h"

#include <gtest/gtest.h>

#include <limits>

#include "raven2_trainer/core/exceptions.h"
#include "render/projection.h"
#include "render_fixture.h"

namespace raven2_trainer::render {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kRadius = 0.02F;  // [m]

class RendererTest : public ::testing::Test {
 protected:
  explicit RendererTest(int width = kWidth, int height = kHeight)
      : renderer_(width, height),
        sphere_(renderer_.addMesh(makeSphere(kRadius, 32))),
        camera_(testCamera(width, height)) {
    empty_ = renderer_.draw(Scene{}, camera_);
  }

  std::vector<std::uint8_t> draw(const std::vector<Drawable>& drawables) {
    Scene scene;
    scene.drawables = drawables;
    return renderer_.draw(scene, camera_);
  }

  Renderer renderer_;
  int sphere_;
  model::Camera camera_;
  std::vector<std::uint8_t> empty_;
};

TEST_F(RendererTest, ASphereAppearsAtThePixelThatTheCameraProjectsAndNowhereElse) {
  const Vector3 places[] = {{0.0, 0.0, 0.0}, {0.1, 0.2, 0.1}, {-0.2, -0.1, 0.15}, {0.15, -0.25, 0.0}};
  for (const Vector3& p_W : places) {
    double u = 0.0, v = 0.0;
    ASSERT_TRUE(camera_.project(p_W, &u, &v));
    const Difference seen = difference(draw({drawable(sphere_, p_W)}), empty_, kWidth);
    const double depth = (camera_.X_WC.inverse() * p_W).z();
    const double radius_px = camera_.fx * kRadius / depth;
    EXPECT_NEAR(seen.u, u, 1.0);
    EXPECT_NEAR(seen.v, v, 1.0);
    EXPECT_NEAR(seen.count, kPi * radius_px * radius_px, 0.4 * kPi * radius_px * radius_px);
    EXPECT_LT(seen.reach, radius_px + 3.0);
  }
}

TEST_F(RendererTest, ACameraThatWasMovedAndBothItsEyesSeeThingsWhereTheirMatricesPutThem) {
  CameraConfig config;
  config.vertical_fov = 0.8;
  config.moves = CameraMoves::kClutch;
  ModelState state;
  state.camera = {{-0.35, 0.45, 0.5}, {0.05, 0.02, 0.03}, {0.0, 0.0, 1.0}};
  for (const double aside : {0.0, -0.03, 0.03}) {
    config.aside = aside;
    camera_ = model::cameraAt(config, state, {}, kWidth, kHeight);
    empty_ = renderer_.draw(Scene{}, camera_);
    for (const Vector3& p_W : {Vector3(0.05, 0.02, 0.03), Vector3(0.1, 0.1, 0.1), Vector3(-0.05, -0.1, 0.0)}) {
      const Difference seen = difference(draw({drawable(sphere_, p_W)}), empty_, kWidth);
      const Vector3 p_C = camera_.X_WC.inverse() * p_W;
      EXPECT_NEAR(seen.u, camera_.fx * p_C.x() / p_C.z() + camera_.cx, 1.0) << aside;
      EXPECT_NEAR(seen.v, camera_.fy * p_C.y() / p_C.z() + camera_.cy, 1.0) << aside;
    }
  }
}

TEST_F(RendererTest, ABlackSceneIsBlackAllOverAndTheNextOneIsSeenAgain) {
  Scene scene;
  scene.drawables = {drawable(sphere_, {0.0, 0.0, 0.05})};
  scene.overlay.lines = {"mode teleoperating"};
  const std::vector<std::uint8_t> seen = renderer_.draw(scene, camera_);
  scene.is_black = true;
  const std::vector<std::uint8_t> black = renderer_.draw(scene, camera_);
  EXPECT_EQ(black, std::vector<std::uint8_t>(seen.size(), 0));
  scene.is_black = false;
  EXPECT_EQ(renderer_.draw(scene, camera_), seen);
}

TEST_F(RendererTest, TheLitSideIsBrightAndTheFarSideDarker) {
  const auto picture = draw({drawable(sphere_, {0.0, 0.0, 0.05})});
  double u = 0.0, v = 0.0;
  ASSERT_TRUE(camera_.project({0.0, 0.0, 0.05 + 0.7 * kRadius}, &u, &v));
  const std::size_t top = 3 * (static_cast<std::size_t>(std::lround(v)) * kWidth + std::lround(u));
  ASSERT_TRUE(camera_.project({0.0, 0.0, 0.05 - 0.7 * kRadius}, &u, &v));
  const std::size_t bottom = 3 * (static_cast<std::size_t>(std::lround(v)) * kWidth + std::lround(u));
  EXPECT_GT(picture[top], 220);
  EXPECT_LT(picture[bottom], 200);
}

TEST_F(RendererTest, AnObjectBehindTheCameraDrawsNothing) {
  const Vector3 behind_W = camera_.X_WC * Vector3(0.0, 0.0, -0.5);
  EXPECT_EQ(draw({drawable(sphere_, behind_W)}), empty_);
}

TEST_F(RendererTest, AnObjectAroundTheCameraShowsOnlyFacesTurnedToIt) {
  Drawable around = drawable(sphere_, camera_.X_WC.p);
  around.X_WM.R *= 10.0;
  EXPECT_EQ(draw({around}), empty_);
}

TEST_F(RendererTest, WhatIsNotFiniteOrHasNoMeshIsLeftOut) {
  Drawable nan_place = drawable(sphere_, {kNan, 0.0, 0.0});
  Drawable nan_turn = drawable(sphere_, {0.0, 0.0, 0.0});
  nan_turn.X_WM.R(1, 2) = kNan;
  Drawable far_away = drawable(sphere_, {std::numeric_limits<double>::infinity(), 0.0, 0.0});
  Drawable nan_colour = drawable(sphere_, {0.0, 0.0, 0.0}, {1.0F, std::numeric_limits<float>::quiet_NaN(), 1.0F, 1.0F});
  EXPECT_EQ(draw({nan_place, nan_turn, far_away, nan_colour, drawable(-1, {0, 0, 0}), drawable(1000, {0, 0, 0})}),
            empty_);
  const Drawable good = drawable(sphere_, {0.0, 0.0, 0.0});
  EXPECT_EQ(draw({nan_place, good, nan_turn}), draw({good}));
}

TEST_F(RendererTest, ACameraThatIsNotFiniteShowsTheBackground) {
  Scene scene;
  scene.drawables = {drawable(sphere_, {0.0, 0.0, 0.0})};
  model::Camera broken = camera_;
  broken.X_WC.p.x() = kNan;
  EXPECT_EQ(renderer_.draw(scene, broken), empty_);
  broken = camera_;
  broken.fx = 0.0;
  EXPECT_EQ(renderer_.draw(scene, broken), empty_);
}

TEST_F(RendererTest, AMeshWithWrongIndicesDrawsTheTrianglesThatExist) {
  model::Mesh mesh = makeSphere(kRadius, 32);
  mesh.triangles.push_back({0, 1, 4'000'000'000U});
  const int damaged = renderer_.addMesh(mesh);
  EXPECT_EQ(draw({drawable(damaged, {0.0, 0.0, 0.0})}), draw({drawable(sphere_, {0.0, 0.0, 0.0})}));
  EXPECT_EQ(draw({drawable(renderer_.addMesh(model::Mesh{}), {0.0, 0.0, 0.0})}), empty_);
}

TEST_F(RendererTest, TheNearerObjectHidesTheFartherInAnyOrder) {
  const Vector3 near_W = camera_.X_WC * Vector3(0.0, 0.0, 0.4), far_W = camera_.X_WC * Vector3(0.0, 0.0, 0.8);
  const Drawable near = drawable(sphere_, near_W, {1.0F, 0.0F, 0.0F, 1.0F});
  const Drawable far = drawable(sphere_, far_W, {0.0F, 0.0F, 1.0F, 1.0F});
  const auto picture = draw({near, far});
  const std::size_t middle = 3 * (static_cast<std::size_t>(kHeight / 2) * kWidth + kWidth / 2);
  EXPECT_GT(picture[middle], picture[middle + 2] + 50);
  EXPECT_EQ(picture, draw({far, near}));
}

TEST_F(RendererTest, AMarkShowsFaintlyThroughWhatHidesIt) {
  const Vector3 near_W = camera_.X_WC * Vector3(0.0, 0.0, 0.4), far_W = camera_.X_WC * Vector3(0.0, 0.0, 0.8);
  const Drawable wall = drawable(sphere_, near_W, {0.2F, 0.2F, 0.2F, 1.0F});
  Drawable mark = drawable(sphere_, far_W, {1.0F, 0.0F, 1.0F, 1.0F});
  const std::size_t middle = 3 * (static_cast<std::size_t>(kHeight / 2) * kWidth + kWidth / 2);
  const auto alone = draw({wall});
  EXPECT_EQ(draw({wall, mark})[middle], alone[middle]) << "only a mark shows through";
  mark.is_mark = true;
  const auto hidden = draw({wall, mark}), shown = draw({mark});
  EXPECT_GT(hidden[middle], alone[middle] + 20);
  EXPECT_LT(hidden[middle], shown[middle] - 40);
  EXPECT_EQ(hidden, draw({mark, wall})) << "the order of drawing does not matter";
}

TEST_F(RendererTest, AMarkInFrontIsPlainAndThrowsNoShadow) {
  Drawable ground = drawable(sphere_, {0.0, 0.0, -0.1});
  ground.X_WM.R *= 5.0;  // its top is at the origin
  const Vector3 above_W = 0.08 * keyLight().cast<double>();
  Drawable above = drawable(sphere_, above_W, {1.0F, 0.0F, 1.0F, 1.0F});
  const auto as_thing = draw({ground, above});
  const Difference shadowed = difference(as_thing, draw({ground}), kWidth);
  above.is_mark = true;
  const auto as_mark = draw({ground, above});
  const Difference marked = difference(as_mark, draw({ground}), kWidth);
  EXPECT_LT(marked.count, shadowed.count - 20) << "a mark throws no shadow on the ground";
  double u = 0.0, v = 0.0;
  ASSERT_TRUE(camera_.project(above_W, &u, &v));
  const std::size_t middle = 3 * (static_cast<std::size_t>(std::lround(v)) * kWidth + std::lround(u));
  EXPECT_EQ(as_mark[middle], as_thing[middle]);
}

TEST_F(RendererTest, PartsOfAMeshMakeUpTheWhole) {
  const Drawable whole = drawable(sphere_, {0.0, 0.0, 0.0});
  Drawable first = whole, rest = whole;
  first.count = 800;  // of 1,088, from below: both parts are seen from above
  rest.first = 800;
  EXPECT_EQ(draw({first, rest}), draw({whole}));
  EXPECT_NE(draw({first}), draw({whole}));
  EXPECT_NE(draw({rest}), draw({whole}));
  first.count = 0;
  rest.first = 1'000'000;
  EXPECT_EQ(draw({first, rest}), empty_);
}

TEST_F(RendererTest, AReplacedMeshIsDrawnInPlaceOfTheOldOne) {
  const int other = renderer_.addMesh(makeArrow(8));
  const auto before = draw({drawable(sphere_, {0.0, 0.0, 0.0})});
  renderer_.replaceMesh(other, makeSphere(kRadius, 32));
  EXPECT_EQ(draw({drawable(other, {0.0, 0.0, 0.0})}), before);
  EXPECT_THROW(renderer_.replaceMesh(other + 1, makeArrow(8)), RenderException);
  EXPECT_THROW(renderer_.replaceMesh(-1, makeArrow(8)), RenderException);
}

TEST_F(RendererTest, ATranslucentObjectLetsWhatIsBehindItThrough) {
  const Vector3 near_W = camera_.X_WC * Vector3(0.0, 0.0, 0.4), far_W = camera_.X_WC * Vector3(0.0, 0.0, 0.8);
  const Drawable ghost = drawable(sphere_, near_W, {1.0F, 0.0F, 0.0F, 0.4F});
  const Drawable blue = drawable(sphere_, far_W, {0.0F, 0.0F, 1.0F, 1.0F});
  const std::size_t middle = 3 * (static_cast<std::size_t>(kHeight / 2) * kWidth + kWidth / 2);
  const auto alone = draw({blue}), both = draw({ghost, blue});
  EXPECT_GT(both[middle], alone[middle] + 40);
  EXPECT_GT(both[middle + 2], 60);
  EXPECT_LT(both[middle + 2], alone[middle + 2]);
}

TEST_F(RendererTest, AnObjectThrowsAShadowOnWhatLiesBelow) {
  Drawable floor = drawable(sphere_, {0.0, 0.0, -10.0}, {0.8F, 0.8F, 0.8F, 1.0F});
  floor.X_WM.R *= 10.0 / kRadius;  // top at z = 0
  const Drawable ball = drawable(sphere_, {0.0, 0.0, 0.1});
  // The key light comes from above and from the surgeon's left. A tenth of a metre below, the shadow has moved by 0.45
  // and -0.40 of that.
  double u = 0.0, v = 0.0;
  ASSERT_TRUE(camera_.project({0.045, -0.04, 0.0}, &u, &v));
  const std::size_t place = 3 * (static_cast<std::size_t>(std::lround(v)) * kWidth + std::lround(u));
  EXPECT_LT(draw({floor, ball})[place] + 30, draw({floor})[place]);
}

/** Sizes with the small and the large shadow map. */
class RendererOfSize : public RendererTest, public ::testing::WithParamInterface<int> {
 protected:
  RendererOfSize() : RendererTest(GetParam() * 16 / 9, GetParam()) {}
};

INSTANTIATE_TEST_SUITE_P(Rows, RendererOfSize, ::testing::Values(180, 360));

TEST_P(RendererOfSize, KeptShadowsOfFixedThingsAreThoseOfThingsThatMove) {
  Drawable floor = drawable(sphere_, {0.0, 0.0, -10.0}, {0.8F, 0.8F, 0.8F, 1.0F});
  floor.X_WM.R *= 10.0 / kRadius;  // top at z = 0
  const int other = renderer_.addMesh(makeSphere(kRadius, 32));
  const Drawable ball = drawable(sphere_, {0.0, 0.0, 0.1}), hand = drawable(sphere_, {0.02, 0.05, 0.15});
  Drawable replaced = drawable(other, {-0.1, 0.0, 0.1}), gone = drawable(sphere_, {0.1, 0.1, 0.1});
  const model::Camera home = camera_;
  const auto pictures = [&](bool are_fixed) {
    std::vector<std::vector<std::uint8_t>> all;
    renderer_.replaceMesh(other, makeSphere(kRadius, 32));
    Drawable fixed_floor = floor, fixed_ball = ball;
    for (Drawable* thing : {&fixed_floor, &fixed_ball, &replaced, &gone})
      thing->is_fixed = are_fixed;
    const std::vector<Drawable> things{fixed_floor, fixed_ball, replaced, gone, hand};
    for (int i = 0; i < 3; ++i)
      all.push_back(draw(things));
    all.push_back(draw({fixed_floor, fixed_ball, replaced, hand}));
    renderer_.replaceMesh(other, makeSphere(2.0F * kRadius, 32));
    all.push_back(draw(things));
    fixed_ball.X_WM.p.x() += 0.03;
    all.push_back(draw({fixed_floor, fixed_ball, replaced, gone, hand}));
    camera_.X_WC.p.y() += 0.05;
    for (int i = 0; i < 3; ++i)
      all.push_back(draw(things));
    camera_ = home;
    all.push_back(draw({}));
    all.push_back(draw({floor, hand}));
    return all;
  };
  const auto moving = pictures(false), fixed = pictures(true);
  ASSERT_EQ(moving.size(), fixed.size());
  for (std::size_t i = 0; i < moving.size(); ++i)
    EXPECT_TRUE(moving[i] == fixed[i]) << i;
  EXPECT_NE(fixed[2], fixed[3]);
  EXPECT_NE(fixed[2], fixed[4]);
  EXPECT_NE(fixed[4], fixed[5]);
}

TEST_F(RendererTest, AShadowOfWhatIsOutOfThePictureIsInIt) {
  Drawable floor = drawable(sphere_, {0.0, 0.0, -10.0}, {0.8F, 0.8F, 0.8F, 1.0F});
  floor.X_WM.R *= 10.0 / kRadius;
  const Vector3 above_W = 0.75 * keyLight().cast<double>();
  ASSERT_FALSE(isInView(camera_, above_W, kRadius));
  double u = 0.0, v = 0.0;
  const Difference shadow = difference(draw({floor, drawable(sphere_, above_W)}), draw({floor}), kWidth);
  ASSERT_TRUE(camera_.project({0.0, 0.0, 0.0}, &u, &v));
  EXPECT_GT(shadow.count, 10);
  EXPECT_NEAR(shadow.u, u, 2.0);
  EXPECT_NEAR(shadow.v, v, 2.0);
}

TEST_F(RendererTest, TheSameSceneGivesTheSamePixelsAgainAndInAnotherRenderer) {
  const std::vector<Drawable> drawables{drawable(sphere_, {0.0, 0.0, 0.05}), drawable(sphere_, {0.03, 0.0, 0.08}),
                                        drawable(sphere_, {0.0, 0.02, 0.1}, {0.9F, 0.1F, 0.1F, 0.5F})};
  const auto first = draw(drawables);
  draw({});
  EXPECT_EQ(draw(drawables), first);
  Renderer other(kWidth, kHeight);
  ASSERT_EQ(other.addMesh(makeSphere(kRadius, 32)), sphere_);
  Scene scene;
  scene.drawables = drawables;
  EXPECT_EQ(other.draw(scene, camera_), first);
  EXPECT_EQ(draw(drawables), first) << "drawing in another context must not disturb this one";
}

TEST_F(RendererTest, TheOverlayChangesPixelsAtTheTopLeftOnly) {
  Scene scene;
  scene.overlay.lines = {"mode teleoperating"};
  const auto& picture = renderer_.draw(scene, camera_);
  int inside = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (picture[i] == empty_[i]) continue;
    ASSERT_LT(static_cast<int>(i / 3) / kWidth, kHeight / 3);
    ASSERT_LT(static_cast<int>(i / 3) % kWidth, kWidth * 3 / 4);
    ++inside;
  }
  EXPECT_GT(inside, 1000);
}

TEST_F(RendererTest, AnInsetChangesPixelsInItsCornerOnly) {
  model::Camera inset = camera_;
  inset.width = 80;
  inset.height = 60;
  const std::vector<std::uint8_t> picture = renderer_.draw(Scene{}, camera_, &inset);
  int changed = 0;
  for (std::size_t i = 0; i < picture.size(); i += 3) {
    if (picture[i] == empty_[i] && picture[i + 1] == empty_[i + 1]) continue;
    ASSERT_GE(static_cast<int>(i / 3) % kWidth, kWidth - 80 - 20);
    ASSERT_GE(static_cast<int>(i / 3) / kWidth, kHeight - 60 - 20);
    ++changed;
  }
  EXPECT_GT(changed, 1000);
  inset.width = 4 * kWidth;
  EXPECT_EQ(renderer_.draw(Scene{}, camera_, &inset), empty_) << "an inset that does not fit is left out";
}

TEST_F(RendererTest, AnInsetShowsShadowsOfWhatTheMainCameraDoesNotSee) {
  Drawable floor = drawable(sphere_, {0.0, 0.0, -10.0}, {0.8F, 0.8F, 0.8F, 1.0F});
  floor.X_WM.R *= 10.0 / kRadius;  // top at z = 0
  const Drawable ball = drawable(sphere_, {0.0, 0.0, 0.1});
  CameraConfig narrow;
  narrow.eye_W = {-0.9, 0.4, 0.6};
  narrow.target_W = {0.02, 0.2, 0.05};
  narrow.up_W = {0.0, 0.0, 1.0};
  narrow.vertical_fov = 0.1;
  const model::Camera inset = testCamera(80, 60), aside = model::makeCamera(narrow, kWidth, kHeight);
  ASSERT_FALSE(isShadowInView(aside, ball.X_WM.p, kRadius));
  ASSERT_TRUE(isInShadowMap(shadowClipFromWorld(aside), ball.X_WM.p, kRadius));
  double u = 0.0, v = 0.0;
  ASSERT_TRUE(inset.project({0.045, -0.04, 0.0}, &u, &v));
  Scene with, without;
  with.drawables = {floor, ball};
  without.drawables = {floor};
  // the corner is 12 pixels from the picture's right and lower ends
  const auto x = kWidth - 12 - 80 + std::lround(u), y = kHeight - 12 - 60 + std::lround(v);
  const auto place = static_cast<std::size_t>(3 * (y * kWidth + x));
  const std::uint8_t lit = renderer_.draw(without, aside, &inset)[place];
  EXPECT_LT(renderer_.draw(with, aside, &inset)[place] + 30, lit);
}

TEST(Renderer, RefusesSizesThatNoPictureHas) {
  EXPECT_THROW(Renderer(0, 100), RenderException);
  EXPECT_THROW(Renderer(100, -1), RenderException);
  EXPECT_THROW(Renderer(5000, 100), RenderException);
}

TEST(Renderer, GivesRgbOfItsSize) {
  Renderer renderer(64, 48);
  EXPECT_EQ(renderer.width(), 64);
  EXPECT_EQ(renderer.height(), 48);
  EXPECT_EQ(renderer.draw(Scene{}, testCamera()).size(), 64U * 48U * 3U);
}

}  // namespace
}  // namespace raven2_trainer::render
