#include "raven2_trainer/session/text_file.h"

#include <sys/stat.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::session {
namespace {

constexpr std::size_t kMaxLine = 65536;
constexpr unsigned kBuffer = 1U << 18U;

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

struct LineReader::Impl {
  std::string path;
  gzFile file{nullptr};
  std::size_t line{0};
  std::array<char, kMaxLine + 2> buffer{};
};

LineReader::LineReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  struct stat status {};
  const bool is_file = ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
  if (is_file) impl_->file = gzopen(path.c_str(), "rb");  // passes through what is not gzipped
  if (impl_->file == nullptr) throw SessionException(path + ":1: cannot be opened");
  gzbuffer(impl_->file, kBuffer);
}

LineReader::~LineReader() {
  gzclose(impl_->file);
}

bool LineReader::next(std::string* line) {
  Impl& s = *impl_;
  ++s.line;
  if (gzgets(s.file, s.buffer.data(), static_cast<int>(s.buffer.size())) == nullptr) {
    int error = Z_OK;
    const char* text = gzerror(s.file, &error);
    if (error != Z_OK && error != Z_STREAM_END) throw SessionException(where() + ": " + text);
    return false;
  }
  line->assign(s.buffer.data());
  if (line->size() > kMaxLine) throw SessionException(where() + ": longer than 65536 characters");
  while (!line->empty() && (line->back() == '\n' || line->back() == '\r'))
    line->pop_back();
  return true;
}

std::string LineReader::where() const {
  return impl_->path + ":" + std::to_string(impl_->line);
}

struct TextWriter::Impl {
  std::string path;
  gzFile file{nullptr};
};

TextWriter::TextWriter(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->file = gzopen(path.c_str(), endsWith(path, ".gz") ? "wb6" : "wbT");
  if (impl_->file == nullptr) throw SessionException(path + ": cannot be created: " + std::strerror(errno));
  gzbuffer(impl_->file, kBuffer);
}

TextWriter::~TextWriter() {
  if (impl_->file != nullptr) gzclose(impl_->file);
}

void TextWriter::write(const std::string& text) {
  if (text.empty()) return;
  if (gzwrite(impl_->file, text.data(), static_cast<unsigned>(text.size())) <= 0) {
    throw SessionException(impl_->path + ": cannot be written: " + std::strerror(errno));
  }
}

void TextWriter::close() {
  const int result = gzclose(impl_->file);
  impl_->file = nullptr;
  if (result != Z_OK) throw SessionException(impl_->path + ": cannot be written: " + std::strerror(errno));
}

}  // namespace raven2_trainer::session
