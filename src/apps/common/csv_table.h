#pragma once

#include <cstdio>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {

/** A table of numbers is wrong. Message: NAME:LINE: column, value, what is expected. */
class CsvException : public Exception {
  using Exception::Exception;
};

/**
 * Reads chosen columns of a table of numbers with a header row. Columns are found by name, in any order; others are
 * ignored, their text with them. Cells are separated by commas, without quotes; lines end in LF or CRLF. Independent of
 * the locale.
 */
class CsvReader {
 public:
  /** Reads the header. @param[in] name of the stream, for messages. @throw CsvException for a missing or double column.
   */
  CsvReader(std::istream& in, std::string name, const std::vector<std::string>& columns);

  /**
   * Reads the next row into `values`, one a wanted column in the order asked for.
   * @return false at the end. @throw CsvException for a row of another length, text, NaN, or a magnitude over 1e6.
   */
  bool next(std::vector<double>* values);

  /** "NAME:LINE" of the row read last. */
  std::string place() const;

 private:
  bool readLine();
  void split();
  void findColumns(const std::vector<std::string>& columns);
  double number(std::size_t column) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::istream& in_;
  std::string name_;
  std::vector<char> buffer_;
  std::string_view line_;
  std::size_t line_number_{0};
  std::vector<std::string_view> cells_;
  std::vector<std::string> header_;
  std::vector<std::size_t> columns_;  // of the cells wanted
};

/** A whole file, or standard input for "-": a row of wanted columns each. @throw CsvException. */
std::vector<std::vector<double>> readTable(const std::string& path, const std::vector<std::string>& columns);

/** Writes rows of cells to a stream, numbers with 17 significant digits: they read back as the same bits. */
class CsvWriter {
 public:
  explicit CsvWriter(std::FILE* out);
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  void header(const std::vector<std::string>& columns);
  void cell(double value);
  void cell(std::string_view text);
  void endRow();
  /** Writes what is left. @throw Exception if the stream takes no more. */
  void flush();

 private:
  std::FILE* out_;
  std::string text_;
};

}  // namespace raven2_trainer::apps
