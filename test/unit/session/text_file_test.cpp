#include "raven2_trainer/session/text_file.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::session {
namespace {

namespace fs = std::filesystem;

class TextFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
};

TEST_F(TextFile, ReadsLinesOfEitherEndAndALastOneWithout) {
  std::ofstream(path("a")) << "one\r\ntwo\n\nfour";
  LineReader reader(path("a"));
  std::string line;
  std::string all;
  while (reader.next(&line))
    all += "<" + line + ">";
  EXPECT_EQ(all, "<one><two><><four>");
}

TEST_F(TextFile, TellsGzipByContentAndNotByName) {
  gzFile file = gzopen(path("plain.csv").c_str(), "wb");
  gzputs(file, "packed\n");
  gzclose(file);
  std::ofstream(path("packed.csv.gz")) << "plain\n";
  std::string line;
  LineReader packed(path("plain.csv"));
  ASSERT_TRUE(packed.next(&line));
  EXPECT_EQ(line, "packed");
  LineReader plain(path("packed.csv.gz"));
  ASSERT_TRUE(plain.next(&line));
  EXPECT_EQ(line, "plain");
}

TEST_F(TextFile, WritesGzipIfTheNameSaysSo) {
  for (const std::string name : {"a.csv", "a.csv.gz"}) {
    TextWriter writer(path(name));
    writer.write("hello\n");
    writer.close();
    std::ifstream raw(path(name), std::ios::binary);
    EXPECT_EQ(raw.get() == 0x1f && raw.get() == 0x8b, name == "a.csv.gz");
    std::string line;
    ASSERT_TRUE(LineReader(path(name)).next(&line));
    EXPECT_EQ(line, "hello");
  }
}

TEST_F(TextFile, NamesFileAndLineOfATornGzip) {
  TextWriter writer(path("torn.gz"));
  for (int k = 0; k < 100000; ++k)
    writer.write(std::to_string(k * 7919 % 10007) + "\n");
  writer.close();
  fs::resize_file(path("torn.gz"), fs::file_size(path("torn.gz")) / 2);
  LineReader reader(path("torn.gz"));
  std::string line;
  try {
    while (reader.next(&line)) {
    }
    FAIL() << "a torn file was taken as whole";
  } catch (const SessionException& e) {
    EXPECT_NE(std::string(e.what()).find("torn.gz:"), std::string::npos) << e.what();
  }
}

TEST_F(TextFile, RefusesWhatCannotBeOpenedAndEndlessLines) {
  EXPECT_THROW(LineReader(path("none")), SessionException);
  EXPECT_THROW(LineReader(folder_.string()), SessionException);
  EXPECT_THROW(TextWriter(path("no/such/folder")), SessionException);
  std::ofstream(path("long")) << std::string(100000, 'x');
  LineReader reader(path("long"));
  std::string line;
  EXPECT_THROW(reader.next(&line), SessionException);
}

}  // namespace
}  // namespace raven2_trainer::session
