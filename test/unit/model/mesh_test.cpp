#include "raven2_trainer/model/mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "test_files.h"

namespace raven2_trainer::model {
namespace {

// A cube of edge 2 about the origin as OBJ: 8 corners, 6 squares, outward.
constexpr const char* kCube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

Vector3 toVector(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

/** Every triangle faces outward and every normal lies along its triangle's; only for bodies star-shaped about 0. */
void expectOutward(const Mesh& mesh, double least_alignment) {
  for (const auto& t : mesh.triangles) {
    const Vector3 a = toVector(mesh.vertices[t[0]]), b = toVector(mesh.vertices[t[1]]),
                  c = toVector(mesh.vertices[t[2]]);
    const Vector3 n = (b - a).cross(c - a).normalized();
    EXPECT_GT(n.dot(a + b + c), 0.0);
    for (const auto i : t)
      EXPECT_GT(toVector(mesh.normals[i]).dot(n), least_alignment);
  }
}

TEST(Mesh, CubeKeepsItsSharpEdges) {
  const Scratch scratch;
  const Mesh cube = loadMesh(scratch.write("cube.obj", kCube), {1, 1, 1});
  EXPECT_EQ(cube.triangles.size(), 12U);
  EXPECT_EQ(cube.vertices.size(), 24U);  // three normals a corner
  EXPECT_EQ(cube.normals.size(), 24U);
  expectOutward(cube, 0.999);
}

TEST(Mesh, ScaleAppliesAndAMirrorImageStaysOutward) {
  const Scratch scratch;
  const Mesh cube = loadMesh(scratch.write("cube.obj", kCube), {-0.5, 2, 1});
  double x = 0, y = 0;
  for (const auto& v : cube.vertices) {
    x = std::max(x, std::abs(static_cast<double>(v[0])));
    y = std::max(y, std::abs(static_cast<double>(v[1])));
  }
  EXPECT_NEAR(x, 0.5, 1e-6);
  EXPECT_NEAR(y, 2.0, 1e-6);
  expectOutward(cube, 0.999);
}

TEST(Mesh, NormalsStaySquareToTheirTrianglesHoweverItIsScaled) {
  // An octahedron: none of its faces is along an axis
  const char* octahedron =
      "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
      "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
  const Scratch scratch;
  const std::string file = scratch.write("octahedron.obj", octahedron);
  for (const std::array<double, 3>& scale : {std::array<double, 3>{1, 3, 0.5}, {0.2, 1, 1}, {-1, 2, -3}, {1, 1, -4}})
    expectOutward(loadMesh(file, scale), 0.999);
}

TEST(Mesh, EachPartKeepsItsOwnCorners) {
  // GIVEN two cubes of different materials, 10 apart
  std::string two = std::string("usemtl a\n") + kCube + "usemtl b\n";
  for (const char* corner : {"-1 -1", "1 -1", "1 1", "-1 1"})
    two += std::string("v ") + corner + " 4\n";
  for (const char* corner : {"-1 -1", "1 -1", "1 1", "-1 1"})
    two += std::string("v ") + corner + " 6\n";
  two += "f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16\n";
  const Scratch scratch;
  const Mesh mesh = loadMesh(scratch.write("two.obj", two), {1, 1, 1});
  EXPECT_EQ(mesh.triangles.size(), 24U);
  int upper = 0;
  for (const auto& t : mesh.triangles) {
    int above = 0;
    for (const auto i : t)
      above += mesh.vertices[i][2] > 2.0F ? 1 : 0;
    EXPECT_TRUE(above == 0 || above == 3) << "a triangle of both cubes";
    upper += above == 3 ? 1 : 0;
  }
  EXPECT_EQ(upper, 12);
}

TEST(Mesh, IsHeldToItsSizeOnEitherSide) {
  const Scratch scratch;
  for (const char* far : {"-11 0 0", "0 -11 0", "0 0 -11", "11 0 0", "0 11 0", "0 0 11"}) {
    const std::string text = std::string("v 0 0 0\nv 1 1 0\nv ") + far + "\nv 0 1 1\nf 1 2 3\nf 1 2 4\n";
    EXPECT_THROW(loadMesh(scratch.write("far.obj", text), {1, 1, 1}), ModelException) << far;
  }
}

TEST(Mesh, FlatBendsBelowFortyDegreesAreSmooth) {
  // Two squares meeting at an angle of `bend`: shared edge vertices keep one normal below 40 degrees, two above.
  const auto vertexCount = [](double bend) {
    const Scratch scratch;
    const std::string x = std::to_string(1 + std::cos(bend)), z = std::to_string(-std::sin(bend));
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv " + x + " 0 " + z + "\nv " + x + " 1 " + z + "\nf 1 2 3 4\nf 2 5 6 3\n";
    return loadMesh(scratch.write("bend.obj", text), {1, 1, 1}).vertices.size();
  };
  EXPECT_EQ(vertexCount(35 * kPi / 180), 6U);
  EXPECT_EQ(vertexCount(45 * kPi / 180), 8U);
}

TEST(Mesh, UnusableFilesAreRefused) {
  const Scratch scratch;
  EXPECT_THROW(loadMesh(scratch.path("absent.stl"), {1, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(scratch.write("empty.stl", ""), {1, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(scratch.write("noise.stl", std::string(90, '\xee')), {1, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(scratch.write("points.obj", "v 0 0 0\nv 1 0 0\n"), {1, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(scratch.write("unknown.xyz", "1 2 3"), {1, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(scratch.write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), {1, 1, 1}), ModelException);
  const std::string cube = scratch.write("cube.obj", kCube);
  EXPECT_THROW(loadMesh(cube, {0, 1, 1}), ModelException);
  EXPECT_THROW(loadMesh(cube, {1, std::nan(""), 1}), ModelException);
  EXPECT_THROW(loadMesh(cube, {1, 1, 11}), ModelException);
  EXPECT_NO_THROW(loadMesh(cube, {1, 1, 10}));
}

TEST(Mesh, TruncatedStlDoesNotCrash) {
  const Scratch scratch;
  const std::string whole = readFile(sourceFile("meshes/jaw.stl"));
  for (std::size_t n = 0; n < whole.size(); n += 997) {
    try {
      loadMesh(scratch.write("cut.stl", whole.substr(0, n)), {1, 1, 1});
      ADD_FAILURE() << n << " bytes accepted";
    } catch (const ModelException&) {
    }
  }
}

TEST(Mesh, TheEndingOfItsNameMayBeInCapitals) {
  const Scratch scratch;
  EXPECT_EQ(loadMesh(scratch.write("CUBE.OBJ", kCube), {1, 1, 1}).triangles.size(), 12U);
  const std::string jaw = readFile(sourceFile("meshes/jaw.stl"));
  EXPECT_EQ(loadMesh(scratch.write("JAW.STL", jaw), {1, 1, 1}).triangles.size(),
            loadMesh(scratch.write("jaw.stl", jaw), {1, 1, 1}).triangles.size());
}

}  // namespace
}  // namespace raven2_trainer::model
