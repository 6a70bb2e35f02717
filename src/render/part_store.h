#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace raven2_trainer::render {

/** Files of a folder of parts next to the parts and their drafts. */
struct PartFolderFiles {
  static constexpr const char* kLock = "lock";
  static constexpr const char* kList = "parts.ffconcat";
  static constexpr const char* kMetadata = "chapters.ffmeta";
  static constexpr const char* kSound = "tones.wav";
  /** The video while it is put together. Each process has its own: an ffmpeg may outlive the one that started it. */
  static std::string whole();
};

/** The lock of a folder of parts: a record lock, which dies with its process and is not inherited, so that a killed
 * render leaves none. */
class PartFolderLock {
 public:
  /** Makes the folder where it is missing. @throw RenderException if it cannot be made, or another process is at work
   * in it. */
  explicit PartFolderLock(const std::string& folder);
  ~PartFolderLock();
  PartFolderLock(const PartFolderLock&) = delete;
  PartFolderLock& operator=(const PartFolderLock&) = delete;

 private:
  bool take(const std::string& folder);

  int file_{-1};
};

/**
 * A video's finished parts in a folder, so that a render that was killed goes on where it was. A part gets its name,
 * which holds hashes of its settings and of its bytes, in one rename once it is whole. So whatever bears the name of a
 * part and has those bytes is one; other files with a name of ours (drafts of the killed, parts of other settings,
 * damaged ones) are removed. Nothing else in the folder is touched.
 */
class PartStore {
 public:
  /**
   * Makes the folder where it is missing, and keeps others out of it as long as this lives. Reads every part.
   * @param[in] settings hash of everything that decides over the pixels, the number of parts included: hexadecimal.
   * @throw RenderException if the folder cannot be made, another process is at work in it, or it holds other files than
   * ours and no lock: then it is somebody's own.
   */
  PartStore(std::string folder, std::string settings, std::size_t count);

  /** Numbers of the parts that are not there, rising. */
  std::vector<std::size_t> missing() const;

  /** Where this process writes part k while it is not whole. */
  std::string draft(std::size_t k) const;

  /** The draft is whole: it becomes part k. For any process. @throw RenderException, SessionException. */
  void keep(std::size_t k) const;

  /** Finds the parts that other processes kept. @return names in the folder, in order. @throw RenderException if one is
   * missing. */
  std::vector<std::string> names();

  const std::string& folder() const noexcept { return folder_; }

  /** Removes our files in the folder, the lock last, and the folder, if nothing else is in it. */
  void remove();

 private:
  std::string prefix(std::size_t k) const;
  void scan(bool check);
  void removeFiles(const std::vector<std::string>& except) const;

  std::string folder_, settings_;
  std::vector<std::string> names_;  // by part; empty: missing
  PartFolderLock lock_;
};

}  // namespace raven2_trainer::render
