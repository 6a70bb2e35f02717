#include "raven2_trainer/net/key_file.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <csignal>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::net {
namespace {

namespace fs = std::filesystem;

class KeyFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("raven2_key_" + std::to_string(::getpid()));
    fs::remove(path_);
  }
  void TearDown() override {
    fs::remove(path_);
    ::prctl(PR_SET_DUMPABLE, 1);
  }

  void write(const std::string& text, mode_t mode) {
    std::ofstream(path_) << text;
    ::chmod(path_.c_str(), mode);
  }

  std::string message() const {
    try {
      loadKeyFile(path_);
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  std::string path_;
};

const std::string kDigits = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1F";

TEST_F(KeyFile, SixtyFourDigitsAreTheKey) {
  for (const mode_t mode : {mode_t{0600}, mode_t{0400}}) {
    for (const char* end : {"", "\n"}) {
      fs::remove(path_);
      write(kDigits + end, mode);
      const auto key = loadKeyFile(path_);
      for (std::uint8_t i = 0; i < 32; ++i)
        EXPECT_EQ(key->data()[i], i);
    }
  }
}

TEST_F(KeyFile, ALoadedKeyForbidsCoreDumps) {
  write(kDigits, 0600);
  ::prctl(PR_SET_DUMPABLE, 1);
  loadKeyFile(path_);
  EXPECT_EQ(::prctl(PR_GET_DUMPABLE), 0);
}

TEST_F(KeyFile, EveryOtherModeIsRefusedWithPathAndMode) {
  for (const mode_t mode : {0644, 0640, 0604, 0660, 0700, 0500, 0666, 01600}) {
    fs::remove(path_);
    write(kDigits, mode);
    EXPECT_NE(message().find(path_), std::string::npos) << message();
    EXPECT_NE(message().find("mode is"), std::string::npos) << message();
  }
  write(kDigits, 0644);
  EXPECT_NE(message().find("0644"), std::string::npos) << message();
}

TEST_F(KeyFile, AnotherUsersFileIsRefused) {
  write(kDigits, 0600);
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to give a file away";
  ASSERT_EQ(::chown(path_.c_str(), 65534, 65534), 0);
  EXPECT_NE(message().find("belongs to user 65534"), std::string::npos) << message();
}

TEST_F(KeyFile, WhatItHoldsIsNeverInTheMessage) {
  const std::string bad[] = {
      "", "00", kDigits.substr(1), kDigits + "0", kDigits + "\n\n", kDigits.substr(2) + "xy", kDigits + "\r\n"};
  for (const std::string& text : bad) {
    write(text, 0600);
    EXPECT_NE(message().find("64 hexadecimal digits"), std::string::npos) << message();
    EXPECT_EQ(message().find("0203"), std::string::npos) << message();
  }
}

TEST_F(KeyFile, LinksFoldersAndNothingAreRefused) {
  EXPECT_NE(message(), "");
  fs::create_symlink("/dev/zero", path_);
  EXPECT_NE(message(), "");
  fs::remove(path_);
  fs::create_directory(path_);
  EXPECT_NE(message().find("no regular file"), std::string::npos) << message();
}

TEST_F(KeyFile, ANewKeyIsReadableByItsOwnerOnlyAndNeverOverwritten) {
  ::umask(0);
  writeKeyFile(path_);
  struct stat info {};
  ASSERT_EQ(::stat(path_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
  EXPECT_EQ(message(), "");
  EXPECT_THROW(writeKeyFile(path_), ConfigException);
  const auto first = loadKeyFile(path_);
  fs::remove(path_);
  writeKeyFile(path_);
  const auto second = loadKeyFile(path_);
  EXPECT_FALSE(std::equal(first->data(), first->data() + 32, second->data()));
}

TEST(FreshNonce, IsFresh) {
  EXPECT_NE(freshNonce(), freshNonce());
}

/** As on a full disk. */
TEST_F(KeyFile, OneThatCannotBeWrittenWholeIsNotLeftBehind) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit ten_bytes{10, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &ten_bytes), 0);
  std::string said;  // nothing may be printed before the limit is lifted
  try {
    writeKeyFile(path_);
  } catch (const ConfigException& e) {
    said = e.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(said.find("cannot be written"), std::string::npos) << said;
  EXPECT_EQ(said.find("Success"), std::string::npos) << said;
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_NO_THROW(writeKeyFile(path_));
}

TEST_F(KeyFile, ALinkToAGoodKeyIsNone) {
  write(kDigits, 0600);
  const std::string other = path_ + "_other";
  fs::rename(path_, other);
  fs::create_symlink(other, path_);
  EXPECT_NE(message().find("cannot be opened"), std::string::npos) << message();
  fs::remove(other);
}

TEST_F(KeyFile, APipeInTheKeysPlaceHoldsNobodyUp) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  ::alarm(20);  // ends a program that waits for a writer
  EXPECT_NE(message().find("no regular file"), std::string::npos) << message();
  ::alarm(0);
}

}  // namespace
}  // namespace raven2_trainer::net
