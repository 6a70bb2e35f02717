#include "ros/rates.h"

#include <gtest/gtest.h>

#include <string>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

diagnostic_msgs::DiagnosticStatus counting(const std::string& name, const std::string& key, std::uint64_t count) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = name;
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = std::to_string(count);
  status.values.push_back(pair);
  return status;
}

std::string rateIn(const diagnostic_msgs::DiagnosticStatus& status) {
  for (const auto& pair : status.values)
    if (pair.key == "rate_hz") return pair.value;
  return "none";
}

std::string rateAfter(Rates* rates, const std::string& key, std::uint64_t count, std::int64_t now_ns) {
  diagnostic_msgs::DiagnosticArray array;
  array.status = {counting("one", key, count)};
  rates->addTo(&array, now_ns);
  return rateIn(array.status[0]);
}

TEST(Rates, AreWhatWasCountedInTheTimeBetween) {
  Rates rates;
  EXPECT_EQ(rateAfter(&rates, "ticks", 5000, 10 * kSecond), "none") << "what was before is not known";
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "ticks", 6000, 11 * kSecond)), 1000.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "ticks", 6030, 13 * kSecond)), 15.0);
}

TEST(Rates, OfAnArrayInBetweenAreThoseOfBefore) {
  Rates rates;
  rateAfter(&rates, "frames", 0, kSecond);
  EXPECT_EQ(rateAfter(&rates, "frames", 7, kSecond + kSecond / 20), "none");
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "frames", 30, 2 * kSecond)), 30.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "frames", 31, 2 * kSecond + kSecond / 20)), 30.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "frames", 45, 3 * kSecond)), 15.0);
}

TEST(Rates, ACounterThatBeganAnewIsNoNegativeRate) {
  Rates rates;
  rateAfter(&rates, "received", 1000000, kSecond);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, "received", 200, 2 * kSecond)), 200.0);
}

TEST(Rates, OfEachStatusByItsNameAndOfWhatCountsAlone) {
  Rates rates;
  for (const std::int64_t second : {1, 2}) {
    diagnostic_msgs::DiagnosticArray array;
    const auto count = static_cast<std::uint64_t>(second);
    array.status = {counting("a", "ticks", 10 * count), counting("b", "received", 20 * count),
                    counting("c", "age_ms", 30 * count)};
    array.status[0].values.push_back(counting("", "frames", 7).values[0]);
    rates.addTo(&array, second * kSecond);
    if (second == 1) continue;
    EXPECT_DOUBLE_EQ(std::stod(rateIn(array.status[0])), 10.0) << "ticks, not frames";
    EXPECT_DOUBLE_EQ(std::stod(rateIn(array.status[1])), 20.0);
    EXPECT_EQ(rateIn(array.status[2]), "none");
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
