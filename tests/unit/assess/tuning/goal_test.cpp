#include "acus/assess/tuning/goal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::tuning {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Goal, BudgetIsReadInEveryUnit) {
  for (const char* text : {"force=0.5ms,image=16ms", "image=16000us,force=500us",
                           "force=0.0005s,image=0.016s", "force=5e-1ms,image=1.6e1ms"}) {
    const Goal goal = ParseBudget(text);
    EXPECT_EQ(goal.kind, GoalKind::kBudget);
    EXPECT_DOUBLE_EQ(goal.force.value(), 500.0) << text;
    EXPECT_DOUBLE_EQ(goal.image.value(), 16.0) << text;
  }
}

TEST(Goal, AccuracyIsReadInEveryUnit) {
  for (const char* text : {"force=0.02N,image=35dB", "image=35dB,force=20mN"}) {
    const Goal goal = ParseAccuracy(text);
    EXPECT_EQ(goal.kind, GoalKind::kAccuracy);
    EXPECT_DOUBLE_EQ(goal.force.value(), 0.02) << text;
    EXPECT_DOUBLE_EQ(goal.image.value(), 35.0) << text;
  }
}

TEST(Goal, OfAModelNamesTheForceOnly) {
  EXPECT_DOUBLE_EQ(ParseForceAccuracyN("force=50mN"), 0.05);
  EXPECT_THROW(ParseForceAccuracyN("image=30dB"), InputError);
  EXPECT_THROW(ParseForceAccuracyN("force=0.1N,image=30dB"), InputError);
}

TEST(Goal, MayNameOnePart) {
  EXPECT_FALSE(ParseBudget("force=1ms").image);
  EXPECT_FALSE(ParseAccuracy("image=30dB").force);
}

TEST(Goal, TextReadsBack) {
  for (const char* text : {"force=0.5ms,image=16ms", "force=0.001ms", "image=33.3ms"}) {
    EXPECT_EQ(TextOf(ParseBudget(text)), text);
  }
  for (const char* text : {"force=0.02N,image=35dB", "force=1e-06N", "image=35.5dB"}) {
    EXPECT_EQ(TextOf(ParseAccuracy(text)), text);
  }
}

TEST(Goal, LiveNeedsAStepAndAnImageInTime) {
  const Goal goal = LiveBudget(1000.0, 30.0);
  EXPECT_DOUBLE_EQ(goal.force.value(), 1000.0);
  EXPECT_DOUBLE_EQ(goal.image.value(), 1000.0 / 30.0);
}

std::string MessageOf(Goal (*parse)(const std::string&), const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "'" << text << "' was taken";
  return {};
}

TEST(Goal, WrongTextsNameWhatIsWrongAndWhatIsAllowed) {
  const struct {
    const char* text;
    const char* why;
  } kBudgets[] = {{"force=abc", "'abc' of force does not begin with a number"},
                  {"", "has no '='"},
                  {"force", "'force' has no '='"},
                  {"force=", "does not begin with a number"},
                  {"force=1", "'1' of force has no unit"},
                  {"force=1N", "'N' is no unit of force"},
                  {"force=1 ms", "' ms' is no unit of force"},
                  {"force=-1ms", "'-1ms' of force must be from"},
                  {"force=0ms", "must be from"},
                  {"force=infms", "must be from"},
                  {"force=nanms", "must be from"},
                  {"force=1e9s", "must be from"},
                  {"forces=1ms", "'forces' is no part"},
                  {"force=1ms,force=2ms", "force is named twice"},
                  {"force=1ms,", "'' has no '='"},
                  {"force=1ms;image=2ms", "'ms;image=2ms' is no unit"}};
  for (const auto& [text, why] : kBudgets) {
    EXPECT_THAT(MessageOf(ParseBudget, text),
                AllOf(HasSubstr(why), HasSubstr(std::string("--budget ") + text + ": "),
                      HasSubstr("force=NUMBER with the unit us, ms or s"),
                      HasSubstr("--budget force=0.5ms,image=16ms")));
  }
  EXPECT_THAT(MessageOf(ParseAccuracy, "image=0.9"), HasSubstr("has no unit"));
  EXPECT_THAT(MessageOf(ParseAccuracy, "image=500dB"), HasSubstr("must be from 0.001dB to 200dB"));
  EXPECT_THAT(MessageOf(ParseAccuracy, "force=1ms"),
              AllOf(HasSubstr("'ms' is no unit of force"),
                    HasSubstr("force=NUMBER with the unit N or mN")));
}

}  // namespace
}  // namespace acus::tuning
