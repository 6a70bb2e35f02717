#include "raven2_trainer/session/record_difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "record_values.h"

namespace raven2_trainer::session {
namespace {

/** A record whose bytes are those of another but for one bit. */
template <typename T>
T withBitFlipped(const T& record, std::size_t offset, unsigned bit) {
  std::array<std::uint8_t, 2048> bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  FieldWriter writer(out);
  visitFields(writer, record);
  bytes[offset] = static_cast<std::uint8_t>(bytes[offset] ^ (1U << bit));
  ByteReader in(bytes.data(), out.size());
  FieldReader reader(in);
  T flipped{};
  visitFields(reader, flipped);
  return flipped;
}

TEST(RecordDifference, IsEmptyForTheSameBitsWhateverTheyMean) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const auto model = randomRecord<ModelState>(random);  // NaN and infinities among them
    EXPECT_EQ(difference(model, ModelState(model)), "");
  }
}

TEST(RecordDifference, NamesTheFieldAndBothValues) {
  ModelState before, now;
  before.arms[1].q[2] = 0.25;
  EXPECT_EQ(difference(now, before), "arms[1].q[2] is 0, was 0.25");
  now = before;
  now.mode = Mode::kTracking;
  EXPECT_EQ(difference(now, before), "mode is tracking, was waiting");
  now = before;
  now.bodies[3].q[0] = -0.0;
  EXPECT_EQ(difference(now, before), "bodies[3].q[0] is -0, was 0") << "-0 is another number: it may lead elsewhere";
  HapticState force, none;
  force.force_B[0][1] = std::nextafter(1.0, 2.0);
  none.force_B[0][1] = 1.0;
  EXPECT_EQ(difference(force, none), "force_B[0][1] is 1.0000000000000002, was 1") << "one bit is a difference";
}

TEST(RecordDifference, NamesWhatOfAnExerciseIsAnother) {
  ExerciseRecord before, now;
  before.event.kind = ExerciseEventKind::kDropped;
  before.event.a = 7;
  now = before;
  EXPECT_EQ(difference(now, before), "");
  now.event.a = 0xFFFF;
  EXPECT_EQ(difference(now, before), "event.a is 65535, was 7");
  now = before;
  now.event.kind = ExerciseEventKind::kHeld;
  EXPECT_EQ(difference(now, before), "event.kind is held, was dropped");
  ModelState state, other;
  other.exercise.mistakes[2] = 3;
  EXPECT_EQ(difference(state, other), "exercise.mistakes[2] is 0, was 3");
}

TEST(RecordDifference, FindsEveryBitOfAContact) {
  Random random(8);
  const auto contact = randomRecord<ContactRecord>(random);
  for (std::size_t offset = 0; offset < sizeof(ContactRecord); ++offset) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      EXPECT_NE(difference(withBitFlipped(contact, offset, bit), contact), "") << offset << '.' << bit;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::session
