#include <gtest/gtest.h>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/hostile_file.h"

// Configuration files made to exhaust or to mislead: each is refused with its place, within a second and 64 MiB.

namespace raven2_trainer::config {
namespace {

using testing::expectRefusedCheaply;

void expectRefused(const std::string& text, const std::string& reason) {
  expectRefusedCheaply<ConfigException>("hostile.yaml", text, reason,
                                        [](const std::string& path) { loadScenario(path, 1, {}); });
}

std::string times(std::size_t n, const std::string& text) {
  std::string all;
  all.reserve(n * text.size());
  for (std::size_t i = 0; i < n; ++i)
    all += text;
  return all;
}

constexpr std::size_t kMebibyte = 1U << 20U;

TEST(HostileYaml, TenMegabytesAreRefused) {
  expectRefused("name: " + std::string(10 * kMebibyte, 'x'), "larger than 1 MiB");
}

TEST(HostileYaml, AnEmptyFileIsRefused) {
  expectRefused("", "expected a mapping");
}

TEST(HostileYaml, BytesThatAreNoTextAreRefused) {
  expectRefused(std::string("\0\x01\xFF\xFE{[\x80", 7), "");
}

TEST(HostileYaml, FlowNestingOfTenThousandIsRefused) {
  expectRefused("name: " + std::string(10000, '['), "nested deeper than 64");
}

TEST(HostileYaml, BlockNestingOfTenThousandIsRefused) {
  expectRefused(times(10000, "- "), "nested deeper than 64");
}

TEST(HostileYaml, NestedMappingsAreRefused) {
  expectRefused(times(10000, "{a: "), "nested deeper than 64");
}

TEST(HostileYaml, NestedKeysAreRefused) {
  expectRefused(times(10000, "? "), "nested deeper than 64");
}

TEST(HostileYaml, AnAliasBombIsRefused) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "*a" + std::to_string(i - 1) + ", ";
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + times(9, before) + "x]\n";
  }
  expectRefused(bomb, "1: anchors (&) are not allowed");
}

TEST(HostileYaml, AnAliasOfItselfIsRefused) {
  expectRefused("name: &a {b: *a}\n", "not allowed");
}

TEST(HostileYaml, TagsAreRefused) {
  expectRefused("name: x\ntitle: !!python/object:os.system [rm]\n", "2: tags (!) are not allowed");
}

TEST(HostileYaml, AMillionValuesAreRefused) {
  expectRefused("name: [" + times(500000, "1,") + "1]\n", "more than 20000 values");
}

TEST(HostileYaml, AMillionEmptyKeysAreRefused) {
  expectRefused("{" + times(500000, ",") + "}", "");
}

TEST(HostileYaml, AMillionLinesOfKeysAreRefused) {
  std::string text;
  for (int i = 0; i < 100000; ++i)
    text += "k" + std::to_string(i) + ":\n";
  expectRefused(text, "20000 values");
}

TEST(HostileYaml, ASecondDocumentIsRefused) {
  expectRefused("name: hostile\n---\nname: other\n", "2: a second document");
}

TEST(HostileYaml, AKeyGivenTwiceIsRefused) {
  expectRefused("name: a\ntitle: b\nname: c\n", "3: name is given twice");
}

TEST(HostileYaml, AListForARootIsRefused) {
  expectRefused("- name: a\n", "expected a mapping");
}

TEST(HostileYaml, ALongValueDoesNotFillTheScreen) {
  expectRefused("name: " + std::string(kMebibyte - 100, 'x') + "\n", "name is not the file's name");
}

TEST(HostileYaml, ALongQuotedValueWithoutEndIsRefused) {
  expectRefused("name: \"" + std::string(kMebibyte - 100, 'x'), "");
}

TEST(HostileYaml, ControlCharactersDoNotReachTheTerminal) {
  expectRefused(
      "name: hostile\ntitle: t\nnumber: 1\nsource: s\npublished: p\nhazard: []\nmaude: []\n"
      "maude_link: \"\\e[2J\\a\"\n",
      "?[2J?");
}

TEST(HostileYaml, AMegabyteOfCommentIsNoScenario) {
  expectRefused(times(kMebibyte / 3, "#x\n"), "expected a mapping");
}

TEST(HostileYaml, AScenarioNamedAsAPathIsRefused) {
  expectRefused("name: ../../etc/passwd\n", "not the file's name");
}

TEST(HostileYaml, AFolderIsRefused) {
  EXPECT_THROW(loadScenario("/", 1, {}), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::config
