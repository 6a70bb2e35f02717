// Logs for the comparison of the C++ reader with the Python reader.
//   log_summary               reads names of logs from stdin. A line for each: intact records of each kind, bad and truncated bytes
//   log_summary --make FILE   makes a small log with records of every kind: plain ones, two chunks, and plain ones
//   log_summary --move FILE   makes a log of moving arms, in chunks, at times with any bits
//   log_summary --ticks FILE  prints the bytes of a log's ticks

#include <cstdio>
#include <cstring>
#include <iostream>
#include <string>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/session/session_log.h"
#include "session/record_codec.h"
#include "session/record_frame.h"
#include "support/moving_ticks.h"

namespace raven2_trainer::session {
namespace {

void make(const std::string& path) {
  LogWriter log(path, LogHeader{}, testing::tickConstants());
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

double anyNumber(Random& random) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(random.next()) << 32U) | random.next();
  double number = 0.0;
  std::memcpy(&number, &bits, sizeof(number));
  return number;
}

/** Any numbers, NaN and infinities too. */
void disturb(Random& random, TickRecord* tick) {
  for (const Arm arm : kArms) {
    ArmState& m = at(tick->model.arms, arm);
    RobotArmState& r = at(tick->robot.arms, arm);
    for (JointArray* joints : {&m.q, &m.dq, &m.q_d, &m.tau, &r.motor, &r.q, &r.dq}) {
      for (double& value : *joints)
        value = anyNumber(random);
    }
  }
}

void move(const std::string& path) {
  LogWriter log(path, LogHeader{}, testing::tickConstants());
  Random random(34);
  testing::MovingTicks ticks(testing::tickConstants());
  for (int i = 0; i < 1500; ++i) {
    TickRecord tick = ticks.next();
    if (i % 500 > 470) disturb(random, &tick);
    log.write(tick);
    if (i % 300 == 299) log.commit();
  }
  log.finish(SessionCounts{});
}

void printTicks(const std::string& path) {
  std::vector<std::uint8_t> bytes(kMaxPayload);
  LogVisitor visitor;
  visitor.tick = [&](const TickRecord& tick) {
    ByteWriter out(bytes.data(), bytes.size());
    FieldWriter fields(out);
    visitFields(fields, tick);
    std::fwrite(bytes.data(), 1, out.size(), stdout);
  };
  readLog(path, visitor);
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
  if (argc == 3 && std::string(argv[1]) == "--move") {
    raven2_trainer::session::move(argv[2]);
    return 0;
  }
  if (argc == 3 && std::string(argv[1]) == "--ticks") {
    raven2_trainer::session::printTicks(argv[2]);
    return 0;
  }
  for (std::string path; std::getline(std::cin, path);)
    raven2_trainer::session::summarise(path);
  return 0;
}
