#include "ros/crtk/crtk_stamp.h"

#include <gtest/gtest.h>

#include <vector>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // [ns]

/** Two clocks that agree, and a thread that is interrupted between the readings that the test names. */
class Interrupted {
 public:
  explicit Interrupted(std::vector<std::int64_t> pauses) : pauses_(std::move(pauses)) {}

  CrtkMoment moment() {
    return momentOf([this] { return pass(); },
                    [this] { return ros::Time().fromNSec(static_cast<std::uint64_t>(pass())); });
  }
  int readings() const { return static_cast<int>(next_); }

 private:
  std::int64_t pass() {
    now_ += next_ < pauses_.size() ? pauses_[next_] : 1000;
    ++next_;
    return now_;
  }

  std::vector<std::int64_t> pauses_;  // [ns] before each reading, then a microsecond
  std::size_t next_{0};
  std::int64_t now_{5'000'000'000};
};

std::int64_t apart(const CrtkMoment& moment) {
  return std::abs(moment.monotonic_ns - static_cast<std::int64_t>(moment.ros.toNSec()));
}

TEST(CrtkMoment, OfAThreadThatIsNotInterruptedTakesThreeReadings) {
  Interrupted thread({});
  EXPECT_LE(apart(thread.moment()), 1000);
  EXPECT_EQ(thread.readings(), 3);
}

TEST(CrtkMoment, IsReadAgainIfTheThreadWasInterruptedOnEitherSideOfTheSecondReading) {
  for (const std::size_t where : {1U, 2U}) {
    std::vector<std::int64_t> pauses(3, 1000);
    pauses[where] = 7 * kMs;
    Interrupted thread(pauses);
    EXPECT_LE(apart(thread.moment()), 1000) << where;
    EXPECT_EQ(thread.readings(), 6);
  }
}

TEST(CrtkMoment, OfAThreadThatIsAlwaysInterruptedIsTheBestOfFive) {
  std::vector<std::int64_t> pauses(100, 8 * kMs);
  pauses[7] = kMs;  // the third time
  pauses[8] = kMs;
  Interrupted thread(pauses);
  EXPECT_LE(apart(thread.moment()), kMs);
  EXPECT_EQ(thread.readings(), 15);
}

TEST(CrtkStamp, IsTheTimeOfTheTickByTheClockOfRos) {
  CrtkStamp stamp;
  EXPECT_EQ(stamp.of(7'000 * kMs, {7'030 * kMs, ros::Time(100, 500)}), ros::Time(99, 970'000'500));
}

TEST(CrtkStamp, IsAlwaysAfterTheLastOneOfTheDevice) {
  CrtkStamp stamp;
  ros::Time last;
  const std::vector<std::int64_t> shifts{0, 5, -3, 0, -2, 4, 4, -9, 0};  // [ms] of the clock of ROS
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const std::int64_t now = (7'000 + 2 * static_cast<std::int64_t>(i)) * kMs;
    const ros::Time ros = ros::Time(1'700'000'000, 0) + ros::Duration().fromNSec(now + shifts[i] * kMs);
    const ros::Time next = stamp.of(now - kMs, {now, ros});
    EXPECT_GT(next.toSec(), last.toSec()) << i << ": also as the float64 of a Python client";
    EXPECT_LT(std::abs((next - ros).toSec()), 0.02) << i;
    last = next;
  }
}

TEST(CrtkStamp, FollowsAClockThatWasSetBack) {
  CrtkStamp stamp;
  stamp.of(7'000 * kMs, {7'000 * kMs, ros::Time(5000.0)});
  EXPECT_EQ(stamp.of(7'002 * kMs, {7'002 * kMs, ros::Time(1000.0)}), ros::Time(1000.0));
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
