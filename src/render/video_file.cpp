#include "raven2_trainer/render/video_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>

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

constexpr std::uint64_t kLongestComment = 1024;
constexpr const char* kSettings = "raven2_trainer settings ";

/** A box without its head. */
struct Box {
  std::string type;
  std::uint64_t begin, end;  // [bytes] in the file
};

/** ISO/IEC 14496-12, 4.2. Nothing if the box goes beyond `end`, or is invalid. */
std::optional<Box> readBox(std::istream* file, std::uint64_t at, std::uint64_t end) {
  if (end - at < kHead) return std::nullopt;
  std::array<unsigned char, kLongHead> head{};
  file->seekg(static_cast<std::streamoff>(at));
  file->read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(std::min(kLongHead, end - at)));
  std::uint64_t size = bigEndian(head.data(), 4), used = kHead;
  if (size == 1 && end - at >= kLongHead) {
    size = bigEndian(head.data() + 8, 8);
    used = kLongHead;
  }
  if (!*file || size < used || size > end - at) return std::nullopt;
  return Box{std::string(reinterpret_cast<const char*>(head.data()) + 4, 4), at + used, at + size};
}

/** The first of this type among the boxes in another. */
std::optional<Box> findBox(std::istream* file, const Box& within, const std::string& type) {
  std::uint64_t at = within.begin;
  while (at < within.end) {
    std::optional<Box> box = readBox(file, at, within.end);
    if (!box || box->type == type) return box;
    at = box->end;
  }
  return std::nullopt;
}

/** The whole file. Nothing: it cannot be read. */
std::optional<Box> allOf(const std::string& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  return Box{"", 0, size};
}

/** Place of the comment's text, as iTunes and ffmpeg put it into MP4 files; nothing if there is no comment. */
std::optional<Box> findComment(std::istream* file, const Box& all) {
  struct Step {
    const char* type;
    std::uint64_t skipped;  // [bytes] before the boxes in it, or before the text
  };
  constexpr std::array<Step, 6> kWay{{{"moov", 0}, {"udta", 0}, {"meta", 4}, {"ilst", 0}, {"\251cmt", 0}, {"data", 8}}};
  Box box = all;
  for (const Step& step : kWay) {
    const std::optional<Box> inner = findBox(file, box, step.type);
    if (!inner || inner->end - inner->begin < step.skipped) return std::nullopt;
    box = {inner->type, inner->begin + step.skipped, inner->end};
  }
  return box;
}

}  // namespace

bool isWholeVideo(const std::string& path) {
  const std::optional<Box> all = allOf(path);
  std::ifstream file(path, std::ios::binary);
  if (!all || !file) return false;
  bool has_index = false;
  std::uint64_t at = 0;
  while (at < all->end) {
    const std::optional<Box> box = readBox(&file, at, all->end);
    if (!box) return false;
    has_index = has_index || box->type == "moov";
    at = box->end;
  }
  return has_index;
}

std::string settingsComment(const std::string& settings) {
  return kSettings + settings;
}

std::string videoSettings(const std::string& path) {
  const std::optional<Box> all = allOf(path);
  std::ifstream file(path, std::ios::binary);
  if (!all || !isWholeVideo(path)) return "";
  const std::optional<Box> comment = findComment(&file, *all);
  if (!comment || comment->end - comment->begin > kLongestComment) return "";
  std::string text(static_cast<std::size_t>(comment->end - comment->begin), '\0');
  file.seekg(static_cast<std::streamoff>(comment->begin));
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  const std::string start = kSettings;
  return file && text.compare(0, start.size(), start) == 0 ? text.substr(start.size()) : "";
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

void markUnfinished(const std::string& video) {
  std::error_code ignored;
  if (isWholeVideo(video)) std::filesystem::create_directory(partFolder(video), ignored);
}

}  // namespace raven2_trainer::render
