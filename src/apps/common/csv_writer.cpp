#include <array>
#include <charconv>

#include "apps/common/csv_table.h"

namespace raven2_trainer::apps {
namespace {

constexpr std::size_t kBlock = 1U << 18U;  // [bytes] written at a time
constexpr int kDigits = 17;                // enough for every double

}  // namespace

CsvWriter::CsvWriter(std::FILE* out) : out_(out) {
  text_.reserve(kBlock + 4096);
}

CsvWriter::~CsvWriter() {
  std::fwrite(text_.data(), 1, text_.size(), out_);  // after an exception: the rows before it
}

void CsvWriter::header(const std::vector<std::string>& columns) {
  for (const std::string& column : columns)
    cell(column);
  endRow();
}

void CsvWriter::cell(double value) {
  std::array<char, 40> digits;
  char* end = digits.data() + digits.size();
  text_.append(digits.data(), std::to_chars(digits.data(), end, value, std::chars_format::general, kDigits).ptr);
  text_ += ',';
}

void CsvWriter::cell(std::string_view text) {
  text_.append(text);
  text_ += ',';
}

void CsvWriter::endRow() {
  text_.back() = '\n';
  if (text_.size() >= kBlock) flush();
}

void CsvWriter::flush() {
  const bool written = std::fwrite(text_.data(), 1, text_.size(), out_) == text_.size() && std::fflush(out_) == 0;
  text_.clear();
  if (!written) throw Exception("output: cannot be written");
}

}  // namespace raven2_trainer::apps
