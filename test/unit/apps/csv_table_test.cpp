#include "apps/common/csv_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace raven2_trainer::apps {
namespace {

/** Reads columns a and b of a table to its end. @return rows, or the message of the exception. */
std::string read(const std::string& text) {
  std::istringstream in(text);
  std::ostringstream out;
  try {
    CsvReader reader(in, "table", {"a", "b"});
    std::vector<double> row;
    while (reader.next(&row))
      out << row.at(0) << '|' << row.at(1) << ';';
  } catch (const CsvException& e) {
    return e.what();
  }
  return out.str();
}

TEST(CsvReader, FindsColumnsByNameAndIgnoresOthers) {
  EXPECT_EQ(read("b,text,a\n2,hello,1\n-4e-1,,3\n"), "1|2;3|-0.4;");
}

TEST(CsvReader, TakesWindowsLinesSpacesAByteOrderMarkAndNoLastNewline) {
  EXPECT_EQ(read("\xEF\xBB\xBF"
                 "a, b\r\n1,\t2 \r\n3,4"),
            "1|2;3|4;");
}

TEST(CsvReader, ATableWithoutRowsIsEmpty) {
  EXPECT_EQ(read("a,b\n"), "");
  EXPECT_EQ(read("a,b"), "");
}

TEST(CsvReader, RefusesWithNameAndLine) {
  const auto refused = [](const std::string& text, const std::string& message) {
    EXPECT_EQ(read(text), "raven2_trainer: table:" + message);
  };
  refused("", "1: no header row");
  refused("a,c\n", "1: column b is missing");
  refused("a,b,a\n", "1: column a is given twice");
  refused("a,b\n1,2\n1\n", "3: 1 cells, expected 2 as in the header");
  refused("a,b\n1,2,3\n", "2: 3 cells, expected 2 as in the header");
  refused("a,b\n\n1,2\n", "2: 1 cells, expected 2 as in the header");
  for (const std::string bad : {"", "x", "1x", "nan", "inf", "-inf", "0x10", "1e400", "2e6", "+1", "\"1\""})
    refused("a,b\n1,1\n1," + bad + "\n", "3: b is \"" + bad + "\", expected a number in [-1e6, 1e6]");
  refused("a,b\n1," + std::string(70000, '1') + "\n", "2: a line of over 65535 characters");
}

TEST(CsvReader, TakesAnEmptyLastLine) {
  EXPECT_EQ(read("a,b\n1,2\n\n"), "1|2;");
}

TEST(CsvReader, KeepsTheSmallestNumbers) {
  EXPECT_EQ(read("a,b\n1e-300,-0\n"), "1e-300|-0;");
}

TEST(CsvWriter, NumbersReadBackAsTheSameBits) {
  const std::vector<double> values{0.1,  -1.0 / 3.0, 4.0 * std::atan(1.0),    1e-300,
                                   -0.0, 123456.789, std::nextafter(1.0, 2.0)};
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  {
    CsvWriter writer(file);
    writer.header({"a", "b"});
    for (const double value : values) {
      writer.cell(value);
      writer.cell(-value);
      writer.endRow();
    }
    writer.flush();
  }
  std::rewind(file);
  std::string text(4096, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  std::istringstream in(text);
  CsvReader reader(in, "written", {"a", "b"});
  std::vector<double> row;
  for (const double value : values) {
    ASSERT_TRUE(reader.next(&row));
    EXPECT_EQ(row[0], value);
    EXPECT_EQ(std::signbit(row[0]), std::signbit(value));
    EXPECT_EQ(row[1], -value);
  }
  EXPECT_FALSE(reader.next(&row));
}

TEST(CsvWriter, AFullDeviceIsReported) {
  std::FILE* full = std::fopen("/dev/full", "wb");
  ASSERT_NE(full, nullptr);
  {
    CsvWriter writer(full);
    writer.header({"a"});
    EXPECT_THROW(writer.flush(), Exception);
  }
  std::fclose(full);
}

}  // namespace
}  // namespace raven2_trainer::apps
