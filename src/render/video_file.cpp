#include "raven2_trainer/render/video_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "render/part_store.h"

namespace raven2_trainer::render {

namespace {

constexpr std::uint64_t kHead = 8;       // [bytes] size and type of a box
constexpr std::uint64_t kLongHead = 16;  // with a size of 64 bits behind the type

std::uint64_t bigEndian(const unsigned char* bytes, int count) noexcept {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i)
    value = (value << 8) | bytes[i];
  return value;
}

}  // namespace

bool isWholeVideo(const std::string& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) return false;
  bool has_index = false;
  std::uint64_t at = 0;
  while (at + kHead <= size) {  // ISO/IEC 14496-12, 4.2
    std::array<unsigned char, kLongHead> head{};
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(std::min(kLongHead, size - at)));
    std::uint64_t box = bigEndian(head.data(), 4);
    if (box == 1 && at + kLongHead <= size) box = bigEndian(head.data() + 8, 8);
    if (!file || box < kHead || box > size - at) return false;
    has_index = has_index || std::string(reinterpret_cast<const char*>(head.data()) + 4, 4) == "moov";
    at += box;
  }
  return has_index && at == size;
}

std::string partFolder(const std::string& video) {
  return std::filesystem::path(video).replace_extension(".parts").string();
}

bool isUnfinished(const std::string& video) {
  const std::filesystem::path folder = partFolder(video);
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return false;
  return std::filesystem::exists(folder / PartFolderFiles::kLock, error) || std::filesystem::is_empty(folder, error);
}

}  // namespace raven2_trainer::render
