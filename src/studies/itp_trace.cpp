#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/text_file.h"
#include "raven2_trainer/studies/replay.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::studies {
namespace {

constexpr std::size_t kMaxRows = 20'000'000;
constexpr double kLongest = 6 * 3600.0;       // [s] of simulated time
constexpr std::int64_t kMaxDatagram = 65507;  // of UDP over IPv4

const std::vector<std::string>& columns() {
  static const std::vector<std::string> names{
      "t_s",    "sequence", "delx0",        "delx1",    "dely0", "dely1",  "delz0",  "delz1",        "Qx0",
      "Qx1",    "Qy0",      "Qy1",          "Qz0",      "Qz1",   "Qw0",    "Qw1",    "buttonstate0", "buttonstate1",
      "grasp0", "grasp1",   "surgeon_mode", "checksum", "size",  "pactyp", "version"};
  return names;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos; comma = line.find(',', begin)) {
    cells.push_back(line.substr(begin, comma - begin));
    begin = comma + 1;
  }
  cells.push_back(line.substr(begin));
  return cells;
}

/** One row of the file by the names of its columns. */
class Row {
 public:
  Row(const std::map<std::string, std::size_t>& columns, const std::vector<std::string>& cells, std::string where)
      : columns_(columns), cells_(cells), where_(std::move(where)) {}

  std::int64_t integer(const std::string& name, std::int64_t low, std::int64_t high) const {
    const double value = number(name);  // spreadsheets write 1.0; 53 bits hold every 32-bit number
    const auto whole =
        static_cast<double>(low) <= value && value <= static_cast<double>(high) && std::trunc(value) == value;
    if (!whole) fail(name, "a whole number in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
    return static_cast<std::int64_t>(value);
  }

  std::int32_t int32(const std::string& name) const {
    using Limits = std::numeric_limits<std::int32_t>;
    return static_cast<std::int32_t>(integer(name, Limits::min(), Limits::max()));
  }

  std::uint32_t uint32(const std::string& name) const {
    return static_cast<std::uint32_t>(integer(name, 0, std::numeric_limits<std::uint32_t>::max()));
  }

  /** An empty cell is 0: a datagram cut short has no later fields. */
  double number(const std::string& name) const {
    const std::string& text = cell(name);
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != '\0') fail(name, "a number");
    return value;
  }

  /** A 32-bit field, written signed or unsigned. */
  std::int32_t bits32(const std::string& name) const {
    const std::int64_t value =
        integer(name, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::uint32_t>::max());
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(value));
  }

  double time(const std::string& name) const {
    const double value = number(name);
    if (cell(name).empty() || !(std::abs(value) < 1e10)) fail(name, "a time in seconds");
    return value;
  }

  template <typename T, typename Read>
  void pair(const std::string& name, PerArm<T>* values, Read read) const {
    (*values)[0] = read(name + "0");
    (*values)[1] = read(name + "1");
  }

 private:
  const std::string& cell(const std::string& name) const { return cells_[columns_.at(name)]; }

  [[noreturn]] void fail(const std::string& name, const std::string& expected) const {
    throw SessionException(where_ + ": " + name + " is \"" + cell(name) + "\", expected " + expected);
  }

  const std::map<std::string, std::size_t>& columns_;
  const std::vector<std::string>& cells_;
  std::string where_;
};

wire::ItpPacket packetOf(const Row& row) {
  const auto int32 = [&](const std::string& name) { return row.int32(name); };
  const auto number = [&](const std::string& name) { return row.number(name); };
  wire::ItpPacket packet;
  packet.sequence = row.uint32("sequence");
  packet.pactyp = row.uint32("pactyp");
  packet.version = row.uint32("version");
  row.pair("delx", &packet.delx_um, int32);
  row.pair("dely", &packet.dely_um, int32);
  row.pair("delz", &packet.delz_um, int32);
  row.pair("Qx", &packet.Qx, number);
  row.pair("Qy", &packet.Qy, number);
  row.pair("Qz", &packet.Qz, number);
  row.pair("Qw", &packet.Qw, number);
  row.pair("buttonstate", &packet.buttonstate, int32);
  row.pair("grasp", &packet.grasp_mrad, int32);
  packet.surgeon_mode = row.int32("surgeon_mode");
  packet.checksum = row.bits32("checksum");
  return packet;
}

TraceDatagram datagramOf(const Row& row) {
  TraceDatagram datagram;
  datagram.t_s = row.time("t_s");
  const wire::ItpBytes bytes = wire::encodeItp(packetOf(row));
  datagram.bytes.assign(bytes.begin(), bytes.end());
  datagram.bytes.resize(static_cast<std::size_t>(row.integer("size", 0, kMaxDatagram)));
  return datagram;
}

std::map<std::string, std::size_t> readHeader(const std::string& line, const std::string& where) {
  std::map<std::string, std::size_t> found;
  for (const std::string& name : split(line)) {
    const std::size_t position = found.size();  // columns of other names are passed over
    if (!found.emplace(name, position).second) throw SessionException(where + ": column " + name + " twice");
  }
  for (const std::string& name : columns()) {
    if (found.count(name) == 0) throw SessionException(where + ": column " + name + " is missing");
  }
  return found;
}

}  // namespace

std::vector<TraceDatagram> readItpTrace(const std::string& path) {
  session::LineReader reader(path);
  std::string line;
  if (!reader.next(&line)) throw SessionException(path + ":1: is empty");
  if (line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);  // byte order mark
  const std::map<std::string, std::size_t> header = readHeader(line, reader.where());
  std::vector<TraceDatagram> trace;
  while (reader.next(&line)) {
    if (line.empty()) continue;
    const std::vector<std::string> cells = split(line);
    if (cells.size() != header.size()) {
      throw SessionException(reader.where() + ": " + std::to_string(cells.size()) + " fields, expected " +
                             std::to_string(header.size()));
    }
    trace.push_back(datagramOf(Row(header, cells, reader.where())));
    const double since_first = trace.back().t_s - trace.front().t_s;
    if (!(std::abs(since_first) <= kLongest)) {
      throw SessionException(reader.where() + ": t_s is " + std::to_string(since_first) +
                             " s after the first, at most 6 h are replayed");
    }
    if (trace.size() > kMaxRows) throw SessionException(reader.where() + ": more than 20 million datagrams");
  }
  return trace;
}

}  // namespace raven2_trainer::studies
