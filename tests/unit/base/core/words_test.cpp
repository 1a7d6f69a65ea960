#include "acus/base/core/words.h"

#include <gtest/gtest.h>
#include <vector>

namespace acus {
namespace {

TEST(Trimmed, TakesAwayWhatSurroundsAndKeepsWhatIsInside) {
  EXPECT_EQ(Trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(Trimmed("a"), "a");
  EXPECT_EQ(Trimmed(" \r\n\t"), "");
  EXPECT_EQ(Trimmed(""), "");
}

TEST(Joined, PutsTheSeparatorBetweenAllWordsAlsoEmptyOnes) {
  EXPECT_EQ(Joined(std::vector<std::string>{}), "");
  EXPECT_EQ(Joined(std::vector<std::string>{"a"}), "a");
  EXPECT_EQ(Joined(std::vector<std::string>{"", "b", ""}), ", b, ");
  EXPECT_EQ(Joined(std::vector<std::string>{"a", "b"}, ","), "a,b");
}

TEST(LinesOf, HaveNoEndsAndTheLastMayLackOne) {
  EXPECT_EQ(LinesOf("a\n\nb"), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_EQ(LinesOf("a\n"), (std::vector<std::string>{"a"}));
  EXPECT_TRUE(LinesOf("").empty());
}

}  // namespace
}  // namespace acus
