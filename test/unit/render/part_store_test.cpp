#include "render/part_store.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

namespace fs = std::filesystem;
using Numbers = std::vector<std::size_t>;

class PartStoreTest : public ::testing::Test {
 protected:
  PartStoreTest() : folder_(fs::temp_directory_path() / ("part_store_test_" + std::to_string(::getpid()))) {}
  ~PartStoreTest() override { fs::remove_all(folder_); }

  std::string folder() const { return folder_.string(); }

  /** Keeps parts of these numbers, each with a different text. */
  void fill(const std::string& settings, std::size_t count, const Numbers& numbers) {
    const PartStore store(folder(), settings, count);
    for (const std::size_t k : numbers)
      keep(store, k);
  }

  static void keep(const PartStore& store, std::size_t k) {
    std::ofstream(store.draft(k)) << "part number " << k;
    store.keep(k);
  }

  fs::path partFile(std::size_t k) const {
    const std::string start = "part_0000" + std::to_string(k);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
      if (entry.path().filename().string().compare(0, start.size(), start) == 0) return entry.path();
    }
    return {};
  }

 private:
  fs::path folder_;
};

TEST_F(PartStoreTest, WhatWasKeptIsThereTheNextTime) {
  fill("a", 5, {1, 4});
  PartStore store(folder(), "a", 5);
  EXPECT_EQ(store.missing(), (Numbers{0, 2, 3}));
  EXPECT_THROW(store.names(), RenderException) << "some parts are missing";
  for (const std::size_t k : {0, 2, 3})
    keep(store, k);
  const auto names = store.names();
  ASSERT_EQ(names.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_EQ(names[k], partFile(k).filename().string());
}

TEST_F(PartStoreTest, ADraftThatWasNotKeptIsRemoved) {
  fill("a", 2, {});
  std::ofstream(folder() + "/draft_00000_4711") << "half a pa";
  EXPECT_EQ(PartStore(folder(), "a", 2).missing(), (Numbers{0, 1}));
  EXPECT_FALSE(fs::exists(folder() + "/draft_00000_4711"));
}

TEST_F(PartStoreTest, PartsOfOtherSettingsAreNotUsedAndRemoved) {
  fill("a", 3, {0, 1});
  EXPECT_EQ(PartStore(folder(), "b", 3).missing(), (Numbers{0, 1, 2}));
  EXPECT_EQ(PartStore(folder(), "a", 3).missing(), (Numbers{0, 1, 2}));
}

TEST_F(PartStoreTest, APartWithAFlippedBitIsNotUsed) {
  fill("a", 3, {0, 1, 2});
  for (const std::streamoff at : {0, 5, 12}) {
    std::fstream file(partFile(1), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(at);
    const int byte = file.get();
    file.seekp(at);
    file.put(static_cast<char>(byte ^ 1));
    file.close();
    EXPECT_EQ(PartStore(folder(), "a", 3).missing(), Numbers{1}) << at;
    fill("a", 3, {1});
    EXPECT_EQ(PartStore(folder(), "a", 3).missing(), Numbers{});
  }
}

TEST_F(PartStoreTest, APartOfHalfItsLengthIsNotUsed) {
  fill("a", 3, {0, 1, 2});
  fs::resize_file(partFile(2), fs::file_size(partFile(2)) / 2);
  EXPECT_EQ(PartStore(folder(), "a", 3).missing(), Numbers{2});
  EXPECT_EQ(partFile(2), fs::path()) << "the part is removed";
}

TEST_F(PartStoreTest, APartBeyondTheLastIsNotUsed) {
  fill("a", 5, {0, 4});
  EXPECT_EQ(PartStore(folder(), "a", 2).missing(), Numbers{1});
  EXPECT_EQ(partFile(4), fs::path());
}

/** Exit status of a child that opens the store. */
int openInAnotherProcess(const std::string& folder) {
  const pid_t id = fork();
  if (id == 0) {
    try {
      const PartStore store(folder, "a", 1);
      _exit(0);
    } catch (const RenderException&) {
      _exit(7);
    }
  }
  int status = 0;
  waitpid(id, &status, 0);
  return WEXITSTATUS(status);
}

TEST_F(PartStoreTest, OneProcessAtATime) {
  {
    const PartStore store(folder(), "a", 1);
    EXPECT_EQ(openInAnotherProcess(folder()), 7);
  }
  EXPECT_EQ(openInAnotherProcess(folder()), 0);
}

TEST_F(PartStoreTest, ManyPartsHaveTheirNumbers) {
  const std::size_t count = 123'457;  // more digits than the usual width of a number
  { keep(PartStore(folder(), "a", count), count - 1); }
  const auto missing = PartStore(folder(), "a", count).missing();
  EXPECT_EQ(missing.size(), count - 1);
  EXPECT_EQ(missing.back(), count - 2);
}

TEST_F(PartStoreTest, RemovesItsFolder) {
  PartStore store(folder(), "a", 1);
  keep(store, 0);
  for (const char* name : {"parts.ffconcat", "chapters.ffmeta", "tones.wav", "whole_4711.mp4", "draft_00000_4711"})
    std::ofstream(folder() + "/" + name) << "ours";
  store.remove();
  EXPECT_FALSE(fs::exists(folder()));
}

TEST_F(PartStoreTest, AFolderOfSomebodyElsesFilesIsRefusedAndLeftAsItIs) {
  fs::create_directories(folder() + "/draft_00000_1");  // a folder with the name of a draft
  std::ofstream(folder() + "/slides.pdf") << "of a talk";
  std::ofstream(folder() + "/part_one.mp4") << "of a talk";
  try {
    PartStore(folder(), "a", 1);
    FAIL() << "the folder was accepted";
  } catch (const RenderException& e) {
    EXPECT_NE(std::string(e.what()).find(folder() + ": is no folder of a video's parts"), std::string::npos)
        << e.what();
  }
  EXPECT_TRUE(fs::exists(folder() + "/slides.pdf"));
  EXPECT_TRUE(fs::exists(folder() + "/part_one.mp4"));
  EXPECT_TRUE(fs::exists(folder() + "/draft_00000_1"));
  EXPECT_FALSE(fs::exists(folder() + "/lock"));
}

TEST_F(PartStoreTest, WhatSomebodyPutBesideThePartsStays) {
  fill("a", 2, {0});
  const std::string notes = folder() + "/notes.txt", inner = folder() + "/more/draft_00000_1";
  fs::create_directories(folder() + "/more");
  std::ofstream(notes) << "somebody's own";
  std::ofstream(inner) << "somebody's own";
  PartStore store(folder(), "b", 2);
  EXPECT_EQ(partFile(0), fs::path()) << "the part of other settings is removed";
  store.remove();
  EXPECT_TRUE(fs::exists(notes));
  EXPECT_TRUE(fs::exists(inner));
  EXPECT_FALSE(fs::exists(folder() + "/lock"));
  EXPECT_THROW(PartStore(folder(), "b", 2), RenderException) << "the folder is no longer a store of parts";
}

TEST_F(PartStoreTest, WhatAKilledRendersFfmpegWroteLaterOnIsNoReasonToRefuse) {
  fs::create_directories(folder());
  std::ofstream(folder() + "/whole_4711.mp4") << "half a video";
  PartStore store(folder(), "a", 1);
  EXPECT_FALSE(fs::exists(folder() + "/whole_4711.mp4"));
}

/** Starts a process that opens and removes the store repeatedly. It exits with 1 if another one is in the store. */
pid_t startVisitor(const std::string& folder, int visits) {
  const pid_t id = fork();
  if (id != 0) return id;
  const std::string alone = folder + ".alone";
  int done = 0;
  while (done < visits) {
    try {
      PartStore store(folder, "a", 1);
      const int file = open(alone.c_str(), O_CREAT | O_EXCL | O_CLOEXEC, 0600);
      if (file < 0) _exit(1);
      close(file);
      unlink(alone.c_str());
      store.remove();
      ++done;
    } catch (const RenderException&) {  // another process is in the store
    }
  }
  _exit(0);
}

TEST_F(PartStoreTest, ALockOfAFolderThatWasRemovedKeepsNobodyOutAndLetsNobodyIn) {
  constexpr int kVisits = 300;
  std::vector<pid_t> visitors;
  for (int i = 0; i < 4; ++i)
    visitors.push_back(startVisitor(folder(), kVisits));
  for (const pid_t visitor : visitors) {
    int status = 0;
    ASSERT_EQ(waitpid(visitor, &status, 0), visitor);
    EXPECT_EQ(status, 0) << "two processes were in the store at once";
  }
  EXPECT_FALSE(fs::exists(folder()));
  fs::remove(folder() + ".alone");
}

TEST_F(PartStoreTest, AFolderThatCannotBeMadeIsAnException) {
  std::ofstream(folder()) << "a file in its place";
  EXPECT_THROW(PartStore(folder(), "a", 1), RenderException);
}

}  // namespace
}  // namespace raven2_trainer::render
