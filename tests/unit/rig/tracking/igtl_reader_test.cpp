#include "acus/rig/tracking/igtl_reader.h"

#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::tracking {
namespace {

const transforms::Pose kPose(Eigen::Isometry3d(Eigen::Translation3d(1.0, 2.0, 3.0)));

Bytes Transform(int i) {
  return PackTransform("Tool" + std::to_string(i), i, kPose);
}
Bytes Joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}
/// Names of all messages that come out.
std::vector<std::string> Names(IgtlReader& reader) {
  std::vector<std::string> names;
  while (const auto message = reader.Next()) names.push_back(message->header.device);
  return names;
}
using Strings = std::vector<std::string>;

TEST(IgtlReader, FindsTheMessagesHoweverTheyAreCut) {
  const Bytes all = Joined({Transform(1), PackQuery("STP_TDATA", "x"), Transform(2)});
  for (const std::size_t step : {1u, 7u, 57u, 58u, 59u, 1000u}) {
    IgtlReader reader({});
    Strings names;
    for (std::size_t at = 0; at < all.size(); at += step) {
      reader.Append(ByteView(all).subspan(at, std::min(step, all.size() - at)));
      for (const std::string& name : Names(reader)) names.push_back(name);
    }
    EXPECT_EQ(names, (Strings{"Tool1", "x", "Tool2"})) << "steps of " << step;
    EXPECT_EQ(reader.counts().skipped_bytes, 0u);
    EXPECT_FALSE(reader.in_message());
  }
}

TEST(IgtlReader, FindsTheNextMessageAfterInvalidData) {
  RandomStream random(3, "rubbish");
  Bytes rubbish(5000);
  for (std::uint8_t& byte : rubbish) byte = static_cast<std::uint8_t>(random.Next());
  IgtlReader reader({});
  reader.Append(Joined({Transform(1), rubbish, Transform(2), Transform(3)}));
  EXPECT_EQ(Names(reader), (Strings{"Tool1", "Tool2", "Tool3"}));
  EXPECT_EQ(reader.counts().skipped_bytes, rubbish.size());
  EXPECT_EQ(reader.counts().messages, 3u);
}

TEST(IgtlReader, AWrongChecksumCostsOneMessage) {
  Bytes broken = Transform(2);
  broken.back() ^= 1;
  IgtlReader reader({});
  reader.Append(Joined({Transform(1), broken, Transform(3)}));
  EXPECT_EQ(Names(reader), (Strings{"Tool1", "Tool3"}));
  EXPECT_EQ(reader.counts().bad_messages, 1u);
  EXPECT_EQ(reader.counts().skipped_bytes, broken.size());

  IgtlReader trusting({.keep_images = false, .check_crc = false});
  trusting.Append(Joined({Transform(1), broken, Transform(3)}));
  EXPECT_EQ(Names(trusting), (Strings{"Tool1", "Tool2", "Tool3"}));
}

TEST(IgtlReader, AMessageThatWasCutOffCostsOnlyItself) {
  Bytes cut = Transform(1);
  cut.resize(70);
  IgtlReader reader({});
  reader.Append(Joined({cut, Transform(2), Transform(3)}));
  EXPECT_EQ(Names(reader), (Strings{"Tool2", "Tool3"}));
}

TEST(IgtlReader, NeverReservesWhatAHeaderPromises) {
  for (const std::uint64_t size :
       {std::uint64_t{48} << 20, std::uint64_t{1} << 40, UINT64_MAX, UINT64_MAX - 57}) {
    for (const char* type : {"TRANSFORM", "TDATA", "STATUS", "IMAGE", "POLYDATA"}) {
      Bytes giant = PackQuery(type, "Giant");
      for (int i = 0; i < 8; ++i) giant[42 + i] = std::uint8_t(size >> (56 - 8 * i));
      IgtlReader reader({.keep_images = true, .check_crc = true});
      reader.Append(giant);
      EXPECT_TRUE(Names(reader).empty());
      EXPECT_LT(reader.memory_bytes(), 1'000u) << type << " of " << size;
      reader.Append(Transform(1));
      EXPECT_LE(Names(reader).size(), 1u);
      EXPECT_LT(reader.memory_bytes(), 1'000u) << type << " of " << size;
    }
  }
}

TEST(IgtlReader, TypesThatAreNotKeptPassWithoutBeingStored) {
  Image image{.width = 1000, .height = 1000, .channels = 1};
  image.pixels.assign(1'000'000, 7);
  const Bytes message = PackImage("Video", 1, image);
  IgtlReader reader({});
  for (std::size_t at = 0; at < message.size(); at += 1000) {
    reader.Append(ByteView(message).subspan(at, std::min<std::size_t>(1000, message.size() - at)));
    EXPECT_FALSE(reader.Next().has_value());
  }
  EXPECT_LT(reader.memory_bytes(), 10'000u);
  EXPECT_EQ(reader.counts().other_messages, 1u);
  EXPECT_EQ(reader.counts().bad_messages, 0u) << "its checksum is looked at all the same";
  reader.Append(Transform(4));
  EXPECT_EQ(Names(reader), Strings{"Tool4"});

  IgtlReader keeping({.keep_images = true, .check_crc = true});
  keeping.Append(message);
  EXPECT_EQ(Names(keeping), Strings{"Video"});
}

// A stream of good messages with bits turned over, bytes lost and bytes put in, cut at random. The
// reader must come back each time, stay small, and find nearly all messages that were not hit.
TEST(IgtlReader, SurvivesBrokenStreams) {
  const transforms::Pose pose;
  const std::pair<std::string, transforms::Pose> tools[] = {{"A", pose}, {"B", kPose}};
  std::uint64_t good = 0, expected = 0;
  for (std::uint64_t round = 0; round < 400; ++round) {
    RandomStream random(round, "broken stream");
    IgtlReader reader({.keep_images = round % 2 == 0, .check_crc = true});
    for (int i = 0; i < 60; ++i) {
      Bytes bytes = Transform(i);
      if (i % 4 == 1) bytes = PackTrackingData("T", i, tools);
      if (i % 4 == 2) bytes = PackTransformWithStatus("S", i, kPose, i % 8 == 2);
      if (i % 4 == 3) bytes = PackStatus("D", i, true, "fine");
      const double chance = random.Uniform();
      const std::size_t at = random.Next() % bytes.size();
      if (chance < 0.1) {
        bytes[at] ^= std::uint8_t(1u << random.Next() % 8);
      } else if (chance < 0.15) {
        bytes.resize(at);
      } else if (chance < 0.2) {
        bytes.insert(bytes.begin() + std::ptrdiff_t(at), 1 + random.Next() % 90,
                     std::uint8_t(random.Next()));
      } else {
        ++expected;
      }
      reader.Append(bytes);
      while (const auto message = reader.Next()) {
        ++good;
        ReadTransform(message->body.content);
        ReadTrackingData(message->body.content);
        ReadStatus(message->body.content);
        ReadPosition(message->body.content);
        ReadImage(message->body.content);
      }
      ASSERT_LT(reader.memory_bytes(), 300'000u);
    }
  }
  // Bits of header fields that the checksum does not cover (name, stamp) may pass.
  EXPECT_GT(good, expected * 97 / 100);
  EXPECT_LT(good, expected * 105 / 100);
}

TEST(IgtlReader, ManyFalseBeginningsTakeNoLongTime) {
  // Headers of messages as large as are kept, one after the other, none of them right: each costs
  // a checksum. 64 KiB of it is all that a client takes before it gives up.
  Bytes evil;
  while (evil.size() < 128 * 1024) {
    Bytes header = PackQuery("STATUS", "x");
    header[48] = 0xff;
    header[49] = 0xff;
    evil.insert(evil.end(), header.begin(), header.end());
  }
  IgtlReader reader({});
  reader.Append(evil);
  EXPECT_TRUE(Names(reader).empty());
  EXPECT_GT(reader.counts().bad_messages, 1000u);
  EXPECT_GT(reader.skipped_in_a_row(), 60'000u);
}

}  // namespace
}  // namespace acus::tracking
