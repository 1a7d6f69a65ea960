#include "acus/base/core/line_reader.h"

#include <array>
#include <gmock/gmock.h>
#include <string>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus {
namespace {

class LinesOfAPipe : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::pipe(ends_.data()), 0); }
  ~LinesOfAPipe() override {
    ::close(ends_[0]);
    Finish();
  }
  void Write(const std::string& text) {
    ASSERT_EQ(::write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void Finish() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

  std::array<int, 2> ends_{-1, -1};
};

TEST_F(LinesOfAPipe, ComeWholeAndInOrder) {
  LineReader lines(ends_[0]);
  EXPECT_FALSE(lines.Next(0));
  Write("one\ntwo\n\nthr");
  EXPECT_EQ(lines.Next(0), "one");
  EXPECT_EQ(lines.Next(0), "two");
  EXPECT_EQ(lines.Next(0), "");
  EXPECT_FALSE(lines.Next(0)) << "half a line is none yet";
  EXPECT_FALSE(lines.at_end());
  Write("ee\nlast");
  EXPECT_EQ(lines.Next(0), "three");
  Finish();
  EXPECT_EQ(lines.Next(0), "last");
  EXPECT_FALSE(lines.Next(0));
  EXPECT_TRUE(lines.at_end());
}

TEST_F(LinesOfAPipe, ThatAreTooLongAreRefusedOnce) {
  LineReader lines(ends_[0]);
  const std::string part(4000, 'x');
  int refused = 0;
  for (int i = 0; i < 40; ++i) {
    Write(part);
    try {
      EXPECT_FALSE(lines.Next(0));
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_EQ(refused, 1);
  Write("\nnext\n");
  EXPECT_FALSE(lines.Next(0)) << "the rest of the long line";
  EXPECT_EQ(lines.Next(0), "next");
}

}  // namespace
}  // namespace acus
