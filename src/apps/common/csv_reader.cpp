#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>

#include "apps/common/csv_table.h"

namespace raven2_trainer::apps {
namespace {

constexpr std::size_t kMaxLine = 1U << 16U;  // [bytes] a line longer than that is no table of numbers
constexpr double kMaxMagnitude = 1e6;        // rad or m: beyond it a value is a mistake of units, or garbage
constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

CsvReader::CsvReader(std::istream& in, std::string name, const std::vector<std::string>& columns)
    : in_(in), name_(std::move(name)), buffer_(kMaxLine) {
  if (!readLine()) {
    line_number_ = 1;
    fail("no header row");
  }
  if (line_.rfind(kByteOrderMark, 0) == 0) line_.remove_prefix(3);
  split();
  for (const std::string_view cell : cells_)
    header_.emplace_back(trimmed(cell));
  findColumns(columns);
}

bool CsvReader::next(std::vector<double>* values) {
  if (!readLine()) return false;
  if (trimmed(line_).empty() && in_.peek() == std::char_traits<char>::eof()) return false;  // an empty last line
  split();
  if (cells_.size() != header_.size()) {
    fail(std::to_string(cells_.size()) + " cells, expected " + std::to_string(header_.size()) + " as in the header");
  }
  values->resize(columns_.size());
  std::transform(columns_.begin(), columns_.end(), values->begin(), [this](std::size_t c) { return number(c); });
  return true;
}

std::string CsvReader::place() const {
  return name_ + ":" + std::to_string(line_number_);
}

bool CsvReader::readLine() {
  in_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  const auto length = static_cast<std::size_t>(in_.gcount());
  if (length == 0 && in_.eof()) return false;
  ++line_number_;
  if (in_.bad()) fail("cannot be read");
  if (in_.fail()) fail("a line of over " + std::to_string(kMaxLine - 1) + " characters");
  line_ = std::string_view(buffer_.data(), in_.eof() ? length : length - 1);  // the newline is counted, not stored
  if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
  return true;
}

void CsvReader::split() {
  cells_.clear();
  std::size_t begin = 0;
  for (std::size_t comma; (comma = line_.find(',', begin)) != std::string_view::npos; begin = comma + 1)
    cells_.push_back(line_.substr(begin, comma - begin));
  cells_.push_back(line_.substr(begin));
}

void CsvReader::findColumns(const std::vector<std::string>& columns) {
  for (const std::string& column : columns) {
    const auto found = std::find(header_.begin(), header_.end(), column);
    if (found == header_.end()) fail("column " + column + " is missing");
    if (std::find(found + 1, header_.end(), column) != header_.end()) fail("column " + column + " is given twice");
    columns_.push_back(static_cast<std::size_t>(found - header_.begin()));
  }
}

double CsvReader::number(std::size_t column) const {
  const std::string_view cell = trimmed(cells_[column]);
  const char* end = cell.data() + cell.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(cell.data(), end, value);
  if (error == std::errc() && rest == end && std::abs(value) <= kMaxMagnitude) return value;
  fail(header_[column] + " is \"" + std::string(cell.substr(0, 40)) + "\", expected a number in [-1e6, 1e6]");
}

void CsvReader::fail(const std::string& what) const {
  throw CsvException(place() + ": " + what);
}

std::vector<std::vector<double>> readTable(const std::string& path, const std::vector<std::string>& columns) {
  const bool piped = path == "-";
  std::ifstream file(path);
  if (!piped && !file) throw CsvException(path + ": cannot be read");
  CsvReader reader(piped ? std::cin : file, piped ? "stdin" : path, columns);
  std::vector<std::vector<double>> rows;
  for (std::vector<double> row; reader.next(&row);)
    rows.push_back(row);
  return rows;
}

}  // namespace raven2_trainer::apps
