#include "raven2_trainer/training/curriculum.h"

#include "gtest/gtest.h"

namespace raven2_trainer::training {
namespace {

Curriculum makeCurriculum() {
  Curriculum curriculum;
  curriculum.stages = {{"pegs", "", 2, 3}, {"rings", "", 2, 0}, {"rings", "jump", 1, 0}};
  return curriculum;
}

/** "p+ p- r+ j+": attempts at pegs, rings and rings with the jump, passed or not. */
std::vector<CurriculumAttempt> attempts(const std::string& text) {
  std::vector<CurriculumAttempt> all;
  for (std::size_t i = 0; i + 1 < text.size(); i += 3)
    all.push_back({text[i] == 'p' ? "pegs" : "rings", text[i] == 'j' ? "jump" : "", text[i + 1] == '+'});
  return all;
}

Progress after(const std::string& text) {
  return follow(makeCurriculum(), attempts(text));
}

TEST(Curriculum, AsksForPassesInARow) {
  EXPECT_EQ(after("").current, 0u);
  EXPECT_EQ(after("p+").stages[0].in_a_row, 1);
  EXPECT_EQ(after("p+ p-").stages[0].in_a_row, 0);
  EXPECT_EQ(after("p+ p- p+").stages[0].in_a_row, 1);
  EXPECT_EQ(after("p+ p- p+ p+").stages[0].in_a_row, 2);
  EXPECT_FALSE(after("p+ p- p+ p+").stages[0].done);
}

TEST(Curriculum, AsksForExtraPassesInAnyOrder) {
  EXPECT_EQ(after("p+ p+ p+ p- p+ p-").stages[0].extra, 2);
  EXPECT_EQ(after("p+ p+ p+ p- p+ p-").stages[0].in_a_row, 2);  // a failure takes nothing back
  EXPECT_FALSE(after("p+ p+ p+ p- p+ p-").stages[0].done);
  EXPECT_TRUE(after("p+ p+ p+ p- p+ p- p+").stages[0].done);
  EXPECT_EQ(after("p+ p+ p+ p- p+ p- p+").current, 1u);
}

TEST(Curriculum, CountsAnAttemptForTheStageUnderWayOnly) {
  const Progress progress = after("r+ r+ p+ r- p+ p+ p+ p+");
  EXPECT_EQ(progress.current, 1u);
  EXPECT_EQ(progress.stages[0].attempts, 5);
  EXPECT_EQ(progress.stages[1].attempts, 0);
}

TEST(Curriculum, TellsAnExerciseFromItsDrill) {
  const std::string pegs = "p+ p+ p+ p+ p+ ";
  EXPECT_EQ(after(pegs + "r+ j+ r+").current, 2u);  // the drill in between is no part of the stage, and breaks no row
  EXPECT_EQ(after(pegs + "r+ r+ r+").current, 2u);
  EXPECT_EQ(after(pegs + "r+ r+ j-").current, 2u);
  EXPECT_EQ(after(pegs + "r+ r+ j- j+ p-").current, 3u);
}

}  // namespace
}  // namespace raven2_trainer::training
