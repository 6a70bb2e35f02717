// log_summary: reads names of logs from stdin. Prints a line for each: number of intact records of every kind, bad
// bytes, truncated bytes. log_summary --make FILE: makes a small log with records of every kind: plain ones, two
// chunks, and plain ones. For the comparison with the Python reader.

#include <cstdio>
#include <iostream>
#include <string>

#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {
namespace {

void make(const std::string& path) {
  LogWriter log(path, LogHeader{});
  for (int i = 0; i < 48; ++i) {
    if (i == 6 || i == 24 || i == 42) log.commit();  // 6 and 18 ticks: 18 KB stay plain, 54 KB become a chunk
    TickRecord tick;
    tick.model.tick = i;
    log.write(tick);
    log.write(HapticRecord{});
    log.write(CommandRecord{i, {}});
    log.write(ContactRecord{});
    if (i % 4 == 0) log.write(RequestRecord{i, {}});
    if (i % 20 == 5) log.write(PlanRecord{i, {}});
    if (i % 8 == 2) log.write(GapRecord{});
  }
  log.finish(SessionCounts{});
}

void summarise(const std::string& path) {
  std::uint64_t counts[8] = {};
  LogVisitor visitor;
  visitor.tick = [&](const TickRecord&) { ++counts[0]; };
  visitor.haptic = [&](const HapticRecord&) { ++counts[1]; };
  visitor.command = [&](const CommandRecord&) { ++counts[2]; };
  visitor.request = [&](const RequestRecord&) { ++counts[3]; };
  visitor.plan = [&](const PlanRecord&) { ++counts[4]; };
  visitor.contact = [&](const ContactRecord&) { ++counts[5]; };
  visitor.gap = [&](const GapRecord&) { ++counts[6]; };
  visitor.counts = [&](const SessionCounts&) { ++counts[7]; };
  const LogSummary summary = readLog(path, visitor);
  for (const std::uint64_t count : counts)
    std::cout << count << ' ';
  std::cout << summary.bad_bytes << ' ' << summary.truncated_bytes << '\n';
}

}  // namespace
}  // namespace raven2_trainer::session

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--make") {
    raven2_trainer::session::make(argv[2]);
    return 0;
  }
  for (std::string path; std::getline(std::cin, path);)
    raven2_trainer::session::summarise(path);
  return 0;
}
