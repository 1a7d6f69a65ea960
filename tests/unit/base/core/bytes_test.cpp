#include "acus/base/core/bytes.h"

#include <gmock/gmock.h>
#include <limits>

namespace acus::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ByteWriter, PutsNumbersInTheGivenOrder) {
  ByteWriter big(std::endian::big);
  big.Number(std::uint16_t{0x0102});
  big.Number(1.0F);  // 0x3f800000
  EXPECT_THAT(big.bytes, ElementsAre(1, 2, 0x3f, 0x80, 0, 0));
  ByteWriter little(std::endian::little);
  little.Number(std::int32_t{-2});
  little.Array(std::span<const std::uint16_t>(std::vector<std::uint16_t>{0x0102}));
  EXPECT_THAT(little.bytes, ElementsAre(0xfe, 0xff, 0xff, 0xff, 1, 0, 0, 0, 0, 0, 0, 0, 2, 1));
}

TEST(ByteWriter, CutsAndFillsTexts) {
  ByteWriter out(std::endian::big);
  out.Text("abc", 2);
  out.Text("d", 3);
  EXPECT_EQ(out.AsString(), std::string("abd\0\0", 5));
}

TEST(ByteReader, ReadsWhatAWriterPutInEitherOrder) {
  for (const std::endian order : {std::endian::big, std::endian::little}) {
    ByteWriter out(order);
    out.Number(std::int64_t{-5'000'000'000});
    out.Array(std::span<const double>(std::vector<double>{0.1, -2e300}));
    out.Text("name", 6);
    out.Array(std::span<const int>());
    const std::string bytes = out.AsString();
    ByteReader in(bytes, order);
    EXPECT_EQ(in.Number<std::int64_t>(), -5'000'000'000);
    EXPECT_THAT(in.Array<double>(), ElementsAre(0.1, -2e300));
    EXPECT_EQ(in.Text(6), "name");
    EXPECT_THAT(in.Array<int>(), IsEmpty());
    EXPECT_TRUE(in.ok());
    EXPECT_EQ(in.left(), 0U);
  }
}

TEST(ByteReader, IsNotOkPastTheEnd) {
  const std::vector<std::uint8_t> bytes = {1, 2, 3};
  ByteReader in(bytes, std::endian::big);
  EXPECT_EQ(in.Number<std::uint16_t>(), 0x0102);
  EXPECT_EQ(in.Number<std::uint16_t>(), 0);
  EXPECT_FALSE(in.ok());
  EXPECT_EQ(in.Number<std::uint8_t>(), 0);
  EXPECT_EQ(in.Text(4), "");
  EXPECT_EQ(in.left(), 0U);
}

TEST(ByteReader, TakesNoArrayThatIsLongerThanItsBytes) {
  for (const std::uint64_t count :
       {std::uint64_t{2}, std::uint64_t{1} << 61, std::numeric_limits<std::uint64_t>::max()}) {
    ByteWriter out(std::endian::little);
    out.Number(count);
    out.Number(7.0);
    ByteReader in(out.bytes, std::endian::little);
    EXPECT_THAT(in.Array<double>(), IsEmpty());
    EXPECT_FALSE(in.ok());
    EXPECT_EQ(in.left(), 0U);
  }
}

}  // namespace
}  // namespace acus::core
