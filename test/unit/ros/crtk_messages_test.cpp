#include "ros/crtk/crtk_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace raven2_trainer::ros_bridge {
namespace {

/** Bytes of a message as they are sent. */
template <typename Message>
std::vector<std::uint8_t> bytesOf(const Message& message) {
  const std::uint32_t size = ros::serialization::serializationLength(message);
  std::vector<std::uint8_t> bytes(size);
  ros::serialization::OStream stream(bytes.data(), size);
  ros::serialization::serialize(stream, message);
  return bytes;
}

/** Little-endian bytes of numbers and texts, put together by hand. */
class Bytes {
 public:
  Bytes& number(std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    return *this;
  }
  Bytes& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  Bytes& byte(std::uint8_t value) {
    bytes_.push_back(value);
    return *this;
  }
  const std::vector<std::uint8_t>& all() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

TEST(CrtkMessages, AnOperatingStateStandsAsInCrtkMsgs) {
  // Header header; string state; bool is_homed; bool is_busy
  crtk::OperatingState message;
  message.header.seq = 7;
  message.header.stamp = ros::Time(1700000000, 250000000);
  message.header.frame_id = "w";
  message.state = "PAUSED";
  message.is_homed = 1;
  const Bytes expected =
      Bytes().number(7).number(1700000000).number(250000000).text("w").text("PAUSED").byte(1).byte(0);
  EXPECT_EQ(bytesOf(message), expected.all());
  EXPECT_EQ(ros::message_traits::datatype(message), std::string("crtk_msgs/OperatingState"));
}

TEST(CrtkMessages, AStringStampedStandsAsInCrtkMsgsAndIsReadBack) {
  // std_msgs/Header header; string string
  crtk::StringStamped message;
  message.header.seq = 1;
  message.header.stamp = ros::Time(2, 3);
  message.string = "enable";
  std::vector<std::uint8_t> bytes = Bytes().number(1).number(2).number(3).text("").text("enable").all();
  EXPECT_EQ(bytesOf(message), bytes);
  crtk::StringStamped read;
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, read);
  EXPECT_EQ(read.string, "enable");
  EXPECT_EQ(read.header.stamp, ros::Time(2, 3));
  EXPECT_EQ(ros::message_traits::datatype(message), std::string("crtk_msgs/StringStamped"));
}

TEST(CrtkMessages, AreNumberedByRoscpp) {
  EXPECT_TRUE(ros::message_traits::hasHeader<crtk::OperatingState>());
  EXPECT_TRUE(ros::message_traits::hasHeader<crtk::StringStamped>());
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
