#include "python/arena.h"

#include <ode/ode.h>
#include <sys/mman.h>

#include <array>
#include <bitset>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

namespace raven2_trainer::python {
namespace {

constexpr std::size_t kGrain = 16;
constexpr std::size_t kClasses = 192;  // four for each power of two

thread_local Arena* current_arena = nullptr;

/** Addresses of all arenas in one piece, so that a pointer says by its value whether and to which it belongs. */
struct Addresses {
  Addresses() {
    void* const reserved =
        mmap(nullptr, Arena::kCapacity * Arena::kMost, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (reserved != MAP_FAILED) begin = static_cast<std::byte*>(reserved);
  }
  bool has(const void* pointer) const noexcept {
    const auto offset = reinterpret_cast<std::uintptr_t>(pointer) - reinterpret_cast<std::uintptr_t>(begin);
    return begin != nullptr && offset < Arena::kCapacity * Arena::kMost;
  }

  std::byte* begin{nullptr};
  std::mutex mutex;
  std::bitset<Arena::kMost> taken;
};

/** Never destroyed: the last blocks are released when the program has almost ended. */
Addresses& addresses() {
  alignas(Addresses) static std::byte place[sizeof(Addresses)];
  static Addresses* const all = new (place) Addresses;
  return *all;
}

/** In front of each block. */
struct Tag {
  std::uint32_t size_class;
  std::uint32_t offset;  ///< [bytes] from the block's own beginning to what was handed out
  std::uint64_t unused;
};
static_assert(sizeof(Tag) == kGrain, "keeps blocks aligned");

struct FreeBlock {
  FreeBlock* next;
};

/** Class whose blocks have at least `size` bytes, in steps of a quarter of a power of two. */
std::size_t classOf(std::size_t size) noexcept {
  const std::size_t grains = (size + kGrain - 1) / kGrain;
  if (grains <= 4) return grains == 0 ? 0 : grains - 1;
  const auto power = static_cast<std::size_t>(63 - __builtin_clzll(grains - 1));
  return 4 * (power - 1) + ((grains - 1) >> (power - 2U)) - 4;
}

std::size_t sizeOf(std::size_t size_class) noexcept {
  if (size_class < 4) return (size_class + 1) * kGrain;
  const std::size_t power = size_class / 4 + 1, quarter = size_class % 4;
  return ((quarter + 5) << (power - 2U)) * kGrain;
}

}  // namespace

struct alignas(kGrain) Arena::Header {
  std::size_t top{sizeof(Header)};
  std::array<FreeBlock*, kClasses> free{};
};

Arena::Arena() {
  Addresses& all = addresses();
  const std::lock_guard<std::mutex> lock(all.mutex);
  std::size_t index = 0;
  while (index < kMost && all.taken[index])
    ++index;
  if (index == kMost)
    throw std::runtime_error("there are " + std::to_string(kMost) +
                             " simulations, the most in one process: delete some");
  if (all.begin == nullptr) throw std::bad_alloc();
  std::byte* const base = all.begin + index * kCapacity;
  if (mprotect(base, kCapacity, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
  all.taken[index] = true;
  base_ = base;
  new (base_) Header;
}

Arena::~Arena() {
  Addresses& all = addresses();
  const std::lock_guard<std::mutex> lock(all.mutex);
  madvise(base_, kCapacity, MADV_DONTNEED);
  mprotect(base_, kCapacity, PROT_NONE);
  all.taken[static_cast<std::size_t>(base_ - all.begin) / kCapacity] = false;
}

void* Arena::allocate(std::size_t size, std::size_t alignment) noexcept {
  auto* const header = reinterpret_cast<Header*>(base_);
  const std::size_t slack = alignment > kGrain ? alignment : 0;
  const std::size_t size_class = classOf(size + sizeof(Tag) + slack);
  std::byte* block = nullptr;
  if (FreeBlock* const found = header->free[size_class]) {
    header->free[size_class] = found->next;
    block = reinterpret_cast<std::byte*>(found);
  } else {
    const std::size_t whole = sizeOf(size_class);
    if (whole > kCapacity - header->top) return nullptr;
    block = base_ + header->top;
    header->top += whole;
  }
  auto place = reinterpret_cast<std::uintptr_t>(block + sizeof(Tag));
  if (slack > 0) place = (place + alignment - 1) & ~(alignment - 1);
  auto* const tag = reinterpret_cast<Tag*>(place - sizeof(Tag));
  tag->size_class = static_cast<std::uint32_t>(size_class);
  tag->offset = static_cast<std::uint32_t>(place - reinterpret_cast<std::uintptr_t>(block));
  return reinterpret_cast<void*>(place);
}

bool Arena::release(void* pointer) noexcept {
  const Addresses& all = addresses();
  if (!all.has(pointer)) return false;
  auto* const place = static_cast<std::byte*>(pointer);
  const auto* const tag = reinterpret_cast<const Tag*>(place - sizeof(Tag));
  const std::size_t size_class = tag->size_class;
  auto* const block = reinterpret_cast<FreeBlock*>(place - tag->offset);
  const std::size_t index = static_cast<std::size_t>(place - all.begin) / kCapacity;
  auto* const header = reinterpret_cast<Header*>(all.begin + index * kCapacity);
  block->next = header->free[size_class];
  header->free[size_class] = block;
  return true;
}

std::size_t Arena::used() const noexcept {
  return reinterpret_cast<const Header*>(base_)->top;
}

std::vector<std::byte> Arena::copy() const {
  return {base_, base_ + used()};
}

void Arena::restore(const std::vector<std::byte>& image) noexcept {
  std::memcpy(base_, image.data(), image.size());
}

Arena* Arena::current() noexcept {
  return current_arena;
}

ArenaScope::ArenaScope(Arena* arena) noexcept : before_(current_arena) {
  current_arena = arena;
}

ArenaScope::~ArenaScope() {
  current_arena = before_;
}

namespace {

void* odeAllocate(dsizeint size) {
  return ::operator new(size);
}

void* odeReallocate(void* old, dsizeint old_size, dsizeint size) {
  void* const place = ::operator new(size);
  std::memcpy(place, old, old_size < size ? old_size : size);
  ::operator delete(old);
  return place;
}

void odeFree(void* pointer, dsizeint /*size*/) {
  ::operator delete(pointer);
}

}  // namespace

namespace {

std::mutex building;

}  // namespace

OdeBuilding::OdeBuilding() {
  building.lock();
  spare_ = dCreateSphere(nullptr, 1.0);  // takes the block that ODE keeps
}

OdeBuilding::~OdeBuilding() {
  dGeomID const of_the_world = dCreateSphere(nullptr, 1.0);  // takes what the world left, if it was destroyed
  dGeomDestroy(static_cast<dGeomID>(spare_));                // ODE keeps this one's
  dGeomDestroy(of_the_world);                                // and frees this one's
  building.unlock();
}

void serveOde() noexcept {
  dSetAllocHandler(odeAllocate);
  dSetReallocHandler(odeReallocate);
  dSetFreeHandler(odeFree);
}

}  // namespace raven2_trainer::python
