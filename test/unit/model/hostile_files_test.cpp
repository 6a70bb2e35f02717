#include <gtest/gtest.h>

#include <limits>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/robot_model.h"
#include "support/hostile_file.h"

// URDF and mesh files made to exhaust or to mislead: each is refused with its place, within a second and 64 MiB.

namespace raven2_trainer::model {
namespace {

using testing::expectRefusedCheaply;

void expectRefused(const std::string& text, const std::string& reason) {
  expectRefusedCheaply<ModelException>("hostile.urdf", text, reason, loadUrdf);
}

void expectMeshRefused(const std::string& name, const std::string& content, const std::string& reason) {
  expectRefusedCheaply<ModelException>(name, content, reason, [](const std::string& path) {
    loadMesh(path, {1.0, 1.0, 1.0});
  });
}

std::string times(std::size_t n, const std::string& text) {
  std::string all;
  all.reserve(n * text.size());
  for (std::size_t i = 0; i < n; ++i)
    all += text;
  return all;
}

std::string robot(const std::string& inside) {
  return "<robot name=\"r\">\n" + inside + "</robot>\n";
}

/** A body of this mass and inertia [ixx = iyy = izz] hanging on the world, written on line 3. */
std::string body(const std::string& mass, const std::string& moment, const std::string& place = "0 0 0") {
  return robot("<link name=\"world\"/>\n<link name=\"body\"><inertial><mass value=\"" + mass + "\"/><inertia ixx=\"" +
               moment + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + moment + "\" iyz=\"0\" izz=\"" + moment +
               "\"/></inertial></link>\n<joint name=\"j\" type=\"floating\"><parent link=\"world\"/>" +
               "<child link=\"body\"/><origin xyz=\"" + place + "\"/></joint>\n");
}

std::string withMesh(const std::string& file) {
  return robot("<link name=\"a\"><visual><geometry><mesh filename=\"" + file + "\"/></geometry></visual></link>\n");
}

TEST(HostileUrdf, TenMegabytesAreRefused) {
  expectRefused(robot("<!--" + std::string(10U << 20U, 'x') + "-->"), "over 2 MiB");
}

TEST(HostileUrdf, AHundredThousandElementsAreRefused) {
  expectRefused(robot(times(100000, "<a/>")), "more than 20000 elements");
}

TEST(HostileUrdf, NestingOfTenThousandIsRefused) {
  expectRefused(robot(times(10000, "<a>") + times(10000, "</a>")), "nested deeper than 64");
}

TEST(HostileUrdf, ATagWithoutEndIsRefused) {
  expectRefused("<robot name=\"" + std::string(1U << 20U, 'x'), "tag is not closed");
}

TEST(HostileUrdf, AnEntityBombIsNotExpanded) {
  std::string bomb = "<!DOCTYPE r [<!ENTITY a \"xxxxxxxxxx\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">";
  expectRefused(bomb + "<!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;\">]>" + robot("<link name=\"&c;\"/>"), "");
}

TEST(HostileUrdf, ALoopOfThreeThousandLinksIsRefused) {
  std::string text;
  for (int i = 0; i < 3000; ++i) {
    const std::string name = "l" + std::to_string(i), next = "l" + std::to_string((i + 1) % 3000);
    text += "<link name=\"" + name + "\"/><joint name=\"j" + name + "\" type=\"fixed\"><parent link=\"" + name +
            "\"/><child link=\"" + next + "\"/></joint>\n";
  }
  expectRefused(robot(text), "loop");
}

TEST(HostileUrdf, LinksWithoutAJointAreRefused) {
  std::string text;
  for (int i = 0; i < 15000; ++i)
    text += "<link name=\"l" + std::to_string(i) + "\"/>\n";
  expectRefused(robot(text), "has no parent joint");
}

TEST(HostileUrdf, MassesNoBodyHasAreRefused) {
  expectRefused(body("-1", "1"), ":3: link 'body': mass -1 kg");
  expectRefused(body("nan", "1"), ":3: ");
  expectRefused(body("5e-324", "1"), ":3: link 'body': mass");
  expectRefused(body("1e300", "1"), ":3: link 'body': mass");
}

TEST(HostileUrdf, InertiasNoBodyHasAreRefused) {
  expectRefused(body("1", "-1"), "not positive definite");
  expectRefused(body("1", "5e-324"), ":3: ");
  expectRefused(body("1", "1e300"), "out of range");
}

TEST(HostileUrdf, PlacesFarAwayAreRefused) {
  expectRefused(body("1", "1", "1e308 0 0"), ":4: joint 'j': origin beyond 100 m");
  expectRefused(body("1", "1", "inf 0 0"), ":4: ");
}

TEST(HostileUrdf, MeshesOutsideTheFolderAreRefused) {
  expectRefused(withMesh("../../../../etc/passwd"), ":2: link 'a': mesh '../../../../etc/passwd' is outside");
  expectRefused(withMesh("/etc/passwd"), "is outside the folder");
  expectRefused(withMesh("package://raven2_trainer/../../../etc/passwd"), "is outside the folder");
  expectRefused(withMesh("package://raven2_trainer//etc/passwd"), "is outside the folder");
  expectRefused(withMesh("file:///etc/passwd"), "only package://raven2_trainer/ is known");
  expectRefused(withMesh("http://example.org/a.stl"), "only package://raven2_trainer/ is known");
}

TEST(HostileUrdf, AMeshThatIsNoMeshIsRefusedWithTheLineOfItsLink) {
  expectRefused(withMesh("hostile.urdf"), ":2: link 'a': mesh 'hostile.urdf'");
}

TEST(HostileUrdf, ANumberThatIsAFormatIsRefused) {
  // urdfdom gives its messages to printf as formats: each of these read memory that is not there, found by fuzzing
  for (const char* number : {"%s%s%s%s%s%s%s%s", "%n%n%n%n%n%n%n%n", "&#37;s&#37;s&#37;s&#37;s",
                             "&#x25;s&#x25;s&#x25;s", "&#4294967333;s&#4294967333;s&#4294967333;s"}) {
    expectRefused(body(number, "1"), ":3: <mass> holds '%', '&'");
  }
}

TEST(HostileUrdf, AFormatHiddenFromOneOfTheTwoReadersIsNone) {
  // a comment to the outline, a link to the parser, for which the CDATA section ends with "]]>"
  const std::string hidden = "<link name=\"b\"><inertial><mass value=\"%s%s%s%s%s%s\"/></inertial></link>";
  expectRefused(robot("<link name=\"a\"/>\n<![CDATA[ > <!-- ]]>" + hidden + "<![CDATA[ --> ]]>\n"), "_s_s_s_s_s_s");
}

TEST(HostileUrdf, AZeroByteInANameIsRefused) {
  std::string text = robot("<link name=\"a\"/>\n<link name=\"b\"/>\n<joint name=\"j?\" type=\"fixed\">" +
                           std::string("<parent link=\"a\"/><child link=\"b\"/></joint>\n"));
  text[text.find('?')] = '\0';
  expectRefused(text, ":4: <joint> holds '%', '&' or a zero byte, which no tag may");
}

TEST(HostileUrdf, AJointHiddenFromOneOfTheTwoReadersIsRefused) {
  const std::string ends = "\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>";
  expectRefused(robot("<link name=\"a\"/>\n<link name=\"b\"/>\n<joint name=\"j" + ends +
                      "<![CDATA[ > <!-- ]]><joint name=\"k" + ends + "<![CDATA[ --> ]]>\n"),
                ":3: link 'b' hangs on joint 'k' of link 'a' in one of two readings of the XML");
}

TEST(UrdfComment, MayHoldAPercentSign) {
  const auto parsed = parseUrdf(robot("<!-- 100 %s &#37; -->\n<link name=\"a\"/>\n"), "a.urdf");
  ASSERT_EQ(parsed.links.size(), 1U);
  EXPECT_EQ(parsed.links[0].name, "a");
}

TEST(HostileUrdf, AReasonFitsAScreen) {
  expectRefused(robot("<link name=\"" + std::string(5000, 'x') + "\"/>\n<link name=\"b\"/>\n"), "x...");
  expectRefused(body(std::string(5000, 'x'), "1"), ":");
  expectRefused(robot("<link name=\"a\"/>\n<link name=\"\x1b[2J\"/>\n"), ":3: link '?[2J'");
}

/** A binary STL that says `count` triangles and holds `held`; corner coordinates all `x`, but for two. */
std::string stl(std::uint32_t count, std::uint32_t held, float x) {
  std::string bytes(80, '\0');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  const float triangle[12] = {0, 0, 1, x, x, x, 1, 0, 0, 0, 1, 0};
  for (std::uint32_t i = 0; i < held; ++i) {
    bytes.append(reinterpret_cast<const char*>(triangle), sizeof(triangle));
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(HostileMesh, ACountBeyondTheFileIsRefused) {
  expectMeshRefused("a.stl", stl(0xFFFFFFFFU, 1, 0.0F), "");
  expectMeshRefused("a.stl", stl(1000000U, 1, 0.0F), "");
}

TEST(HostileMesh, NumbersThatAreNotFiniteAreRefused) {
  expectMeshRefused("a.stl", stl(1, 1, std::numeric_limits<float>::quiet_NaN()), "not finite");
  expectMeshRefused("a.stl", stl(1, 1, std::numeric_limits<float>::infinity()), "not finite");
  expectMeshRefused("a.stl", stl(1, 1, 1e30F), "larger than 10 m");
}

TEST(HostileMesh, EmptyAndCutFilesAreRefused) {
  expectMeshRefused("a.stl", "", "");
  expectMeshRefused("a.stl", std::string(83, '\0'), "");
  expectMeshRefused("a.stl", "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0", "");
  expectMeshRefused("a.obj", "", "");
}

TEST(HostileMesh, IndicesBeyondTheVerticesAreRefused) {
  expectMeshRefused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999\n", "");
  expectMeshRefused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -99999999\n", "");
}

TEST(HostileMesh, OneLineAsLongAsTheFileIsNotReadBeyondItsEnd) {
  // found by fuzzing; AddressSanitizer reports a read beyond the end
  expectMeshRefused("a.obj", "llib /etc/ /etc/[\x01mtllib /etc/passwas\x8d\x88\x9b\xf1v/etc/papad\n", "");
  expectMeshRefused("a.obj", "v 0 0 0 f 1 2 3 12", "");
  expectMeshRefused("a.obj", "f 1 2 3             \n", "");
}

TEST(HostileMesh, FormatsThatNobodyNeedsAreRefused) {
  expectMeshRefused("a.blend", "BLENDER-v248", "no mesh format");
  expectMeshRefused("a", "solid a", "no mesh format");
}

TEST(HostileMesh, AHugeFileIsRefusedUnread) {
  expectRefusedCheaply<ModelException>("a.stl", "", "over 64 MiB", [](const std::string& path) {
    std::filesystem::resize_file(path, 10ULL << 30U);  // sparse
    loadMesh(path, {1.0, 1.0, 1.0});
  });
}

}  // namespace
}  // namespace raven2_trainer::model
