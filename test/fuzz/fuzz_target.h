#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

// A fuzz target is one source NAME_fuzz.cpp with libFuzzer's entry. For all bytes it must return, and its calls of
// require() must hold. libFuzzer drives it (scripts/fuzz); replay_test.cpp drives the same entry without clang.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace raven2_trainer::fuzz {

using Bytes = std::vector<std::uint8_t>;

/** Checks a promise of the target. Throws none of this package's exceptions, which targets catch as refusals. */
inline void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("does not hold: ") + what);
}

/** Counts the messages that a target has judged: an input may hold several. Prints the count at the end in libFuzzer's
 *  format. */
class MessageCount {
 public:
  ~MessageCount() {
    if (count_ > 0) std::fprintf(stderr, "stat::messages: %llu\n", static_cast<unsigned long long>(count_));
  }
  void operator++() { ++count_; }

 private:
  std::uint64_t count_{0};
};

/** Splits an input into its parts; zeros behind its end. */
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  bool empty() const { return left_ == 0; }
  std::size_t left() const { return left_; }
  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  std::uint16_t word() {
    const unsigned low = byte();
    return static_cast<std::uint16_t>(low | (static_cast<unsigned>(byte()) << 8U));
  }
  /** At most `size` bytes: fewer if fewer are left. */
  Bytes take(std::size_t size) {
    const std::size_t n = size < left_ ? size : left_;
    Bytes bytes(data_, data_ + n);
    data_ += n;
    left_ -= n;
    return bytes;
  }
  std::string rest() {
    const Bytes all = take(left_);
    return std::string(all.begin(), all.end());
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/**
 * Reads the rest of an input as edits of a good text: place, number of bytes to delete, bytes to insert. Small changes
 * of a large file reach deeper than any text that a fuzzer finds by itself.
 */
inline std::string edited(std::string text, Input* input) {
  while (!input->empty()) {
    const std::size_t at = input->word() % (text.size() + 1);
    const std::size_t gone = input->byte() % 64;
    const Bytes come = input->take(input->byte() % 64);
    text.replace(at, gone, std::string(come.begin(), come.end()));
  }
  return text;
}

/** A folder of this process in memory, removed at its end. */
class ScratchFolder {
 public:
  ScratchFolder() {
    const std::filesystem::path memory = "/dev/shm";
    const auto parent = access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
    path_ = parent / ("raven2_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path(name);
  }

 private:
  std::filesystem::path path_;
};

inline std::string readWhole(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

inline std::string sourceFile(const std::string& name) {
  return std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/" + name;
}

/** "FILE:LINE: " must begin every refusal of a file. */
inline void requirePlace(const std::string& message, const std::string& file) {
  const std::size_t at = message.find(file + ":");
  require(at != std::string::npos, "a refusal names the file");
  const std::size_t line = at + file.size() + 1;
  require(line < message.size() && message[line] >= '0' && message[line] <= '9', "a refusal names the line");
  require(message.size() < 1000 + file.size(), "a refusal fits a screen");
}

}  // namespace raven2_trainer::fuzz
