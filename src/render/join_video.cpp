#include "render/join_video.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "render/edge_tone.h"
#include "render/ffmpeg_process.h"
#include "render/part_store.h"

namespace raven2_trainer::render {

namespace {

/** As ffmpeg's metadata files want it. */
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::strchr("=;#\\\n", c) != nullptr && c != '\0') out += '\\';
    out += c;
  }
  return out;
}

void writeFile(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw RenderException(path + ": cannot be written");
}

std::string partList(const VideoPieces& pieces) {
  std::string out = "ffconcat version 1.0\n";
  for (const std::string& part : pieces.parts)
    out += "file " + part + "\n";
  return out;
}

std::string metadata(const VideoPieces& pieces) {
  std::string out = ";FFMETADATA1\ntitle=" + escaped(pieces.title) + "\ndescription=" + escaped(pieces.description) +
                    "\ncomment=" + escaped(pieces.comment) + "\n";
  for (std::size_t i = 0; i < pieces.chapters.size(); ++i) {
    const bool is_last = i + 1 == pieces.chapters.size();
    const std::int64_t end = is_last ? pieces.length_ms : pieces.chapters[i + 1].start_ms;
    out += "[CHAPTER]\nTIMEBASE=1/1000\nSTART=" + std::to_string(pieces.chapters[i].start_ms) +
           "\nEND=" + std::to_string(end) + "\ntitle=" + escaped(pieces.chapters[i].title) + "\n";
  }
  return out;
}

/** Without the date and the versions that ffmpeg would note: the same pieces give the same bytes. */
std::vector<std::string> joinArguments(const std::string& parts,
                                       const std::string& described,
                                       const std::string& sound,
                                       const std::string& output) {
  std::vector<std::string> out{"-nostdin",      "-y", "-f",         "concat", "-i",
                               "file:" + parts, "-f", "ffmetadata", "-i",     "file:" + described};
  const auto add = [&out](const std::vector<std::string>& more) { out.insert(out.end(), more.begin(), more.end()); };
  if (!sound.empty()) add({"-i", "file:" + sound});
  add({"-map", "0:v", "-c:v", "copy", "-map_metadata", "1", "-map_chapters", "1"});
  if (!sound.empty()) add({"-map", "2:a", "-threads", "1", "-c:a", "aac", "-b:a", "48k", "-flags:a", "+bitexact"});
  add({"-movflags", "+faststart", "-fflags", "+bitexact", "-f", "mp4", "file:" + output});
  return out;
}

}  // namespace

void joinVideo(const VideoPieces& pieces, const std::string& path) {
  const std::string start = pieces.folder + "/";
  const std::string parts = start + PartFolderFiles::kList, described = start + PartFolderFiles::kMetadata;
  const std::string sound = pieces.tones.empty() ? "" : start + PartFolderFiles::kSound;
  const std::string whole = start + PartFolderFiles::whole();
  writeFile(parts, partList(pieces));
  writeFile(described, metadata(pieces));
  if (!sound.empty()) writeTones(sound, pieces.tones, pieces.length_ms);
  FfmpegProcess(joinArguments(parts, described, sound, whole), path).finish();
  if (std::rename(whole.c_str(), path.c_str()) != 0) throw RenderException(path + ": " + std::strerror(errno));
}

}  // namespace raven2_trainer::render
