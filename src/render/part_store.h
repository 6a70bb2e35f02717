#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace raven2_trainer::render {

/**
 * A video's finished parts in a folder, so that a render that was killed goes on where it was. A part gets its name,
 * which holds hashes of its settings and of its bytes, in one rename once it is whole. So whatever bears the name of a
 * part and has those bytes is one; everything else in the folder is removed.
 */
class PartStore {
 public:
  /**
   * Makes the folder where it is missing, and keeps others out of it as long as this process lives. Reads every part.
   * @param[in] settings hash of everything that decides over the pixels, the number of parts included.
   * @throw RenderException if the folder cannot be made, or another process is at work in it.
   */
  PartStore(std::string folder, std::string settings, std::size_t count);
  /** Lets others in. */
  ~PartStore();
  PartStore(const PartStore&) = delete;
  PartStore& operator=(const PartStore&) = delete;

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

  /** Removes the folder and what is in it. */
  void remove();

 private:
  std::string prefix(std::size_t k) const;
  void lock();
  void scan(bool check);
  void removeOthers() const;

  std::string folder_, settings_;
  std::vector<std::string> names_;  // by part; empty: missing
  int lock_{-1};
};

}  // namespace raven2_trainer::render
