#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace raven2_trainer::python {

/**
 * Memory of one simulation: everything that `new` and ODE allocate while it is current on a thread. It stays at its
 * addresses, so a copy of it is a snapshot of all state in it, pointers included. One thread at a time.
 */
class Arena {
 public:
  /** @throw std::runtime_error if there are kMost of them, std::bad_alloc if there is no address space. */
  Arena();
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  static constexpr std::size_t kCapacity = std::size_t{256} << 20U;  ///< [bytes] of addresses; used are what is needed
  static constexpr std::size_t kMost = 256;

  /** @param[in] alignment a power of two. @return null if it is full. */
  void* allocate(std::size_t size, std::size_t alignment) noexcept;

  /** [bytes] from its beginning to the end of the highest block. */
  std::size_t used() const noexcept;
  /** A copy of the first used() bytes. */
  std::vector<std::byte> copy() const;
  /** Contents and free blocks as they were at copy(). */
  void restore(const std::vector<std::byte>& image) noexcept;

  /** Null: `new` allocates from the heap. */
  static Arena* current() noexcept;
  /** @return false if the pointer is of no arena. */
  static bool release(void* pointer) noexcept;

 private:
  friend class ArenaScope;
  struct Header;

  std::byte* base_{nullptr};
};

/** Makes an arena current on this thread, or none with a null pointer, until its end. */
class ArenaScope {
 public:
  explicit ArenaScope(Arena* arena) noexcept;
  ~ArenaScope();
  ArenaScope(const ArenaScope&) = delete;
  ArenaScope& operator=(const ArenaScope&) = delete;

 private:
  Arena* before_;
};

/**
 * ODE keeps one block of a destroyed geometry for the next one, in any world. While one of these is there, the block
 * that it keeps is of no arena before a world is built, and again afterwards. One at a time; between initialising ODE
 * and its end.
 */
class OdeBuilding {
 public:
  OdeBuilding();
  ~OdeBuilding();
  OdeBuilding(const OdeBuilding&) = delete;
  OdeBuilding& operator=(const OdeBuilding&) = delete;

 private:
  void* spare_;
};

/** ODE's memory too is that of the current arena, from now on. Before ODE allocates anything. */
void serveOde() noexcept;

}  // namespace raven2_trainer::python
