// What goes over the link to the second computer: the same bits at the other end, or nothing.
#include "acus/run/live/image_protocol.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/rig/tracking/igtl_reader.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::live {
namespace {

using tracking::Bytes;
using tracking::ByteView;

transforms::Pose SteppedPose(RandomStream& random) {
  const auto number = [&random] { return 2.0 * random.Uniform() - 1.0; };
  const Eigen::Quaterniond q(number(), number(), number(), number());
  return {q.normalized(), Eigen::Vector3d(100.0 * number(), 100.0 * number(), 100.0 * number())};
}

std::vector<StepInput> SomeSteps(std::size_t count) {
  RandomStream random(5, "steps");
  std::vector<StepInput> steps(count);
  for (std::size_t i = 0; i < count; ++i) {
    StepInput& step = steps[i];
    step.time_ns = 123'456'789'012'345 + 1'000'003 * static_cast<std::int64_t>(i);
    step.needle = {step.time_ns, SteppedPose(random), i % 3 != 0};
    step.probe = {step.time_ns, SteppedPose(random), i % 2 == 0};
    step.breath.cycle = random.Uniform();
    step.breath.level = random.Uniform();
    step.breath.level_per_s = random.Uniform() - 0.5;
    if (i % 4 == 1) step.gain_db = 3.7;
    if (i % 5 == 1) step.depth_mm = 123.4;
  }
  return steps;
}

ByteView ContentOf(const Bytes& message) {
  return ByteView(message).subspan(tracking::kIgtlHeaderBytes);
}

TEST(ImageProtocol, StepsArriveInEveryBit) {
  const auto steps = SomeSteps(kMostStepsInMessage);
  const Bytes message = PackSteps(steps, 41);
  const auto read = ReadSteps(ContentOf(message), 41, steps[0].time_ns - 1);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepInput& a = steps[i];
    const StepInput& b = (*read)[i];
    EXPECT_EQ(a.time_ns, b.time_ns);
    EXPECT_EQ(b.needle.time_ns, a.time_ns);
    EXPECT_TRUE(a.needle.reference_from_tool == b.needle.reference_from_tool) << i;
    EXPECT_TRUE(a.probe.reference_from_tool == b.probe.reference_from_tool) << i;
    EXPECT_EQ(a.needle.valid, b.needle.valid);
    EXPECT_EQ(a.probe.valid, b.probe.valid);
    EXPECT_EQ(a.breath.cycle, b.breath.cycle);
    EXPECT_EQ(a.breath.level, b.breath.level);
    EXPECT_EQ(a.breath.level_per_s, b.breath.level_per_s);
    EXPECT_EQ(a.gain_db, b.gain_db);
    EXPECT_EQ(a.depth_mm, b.depth_mm);
  }
}

TEST(ImageProtocol, StepsThatCannotBeAreRefused) {
  const auto steps = SomeSteps(3);
  const auto refused = [](const std::vector<StepInput>& wrong) {
    return !ReadSteps(ContentOf(PackSteps(wrong, 0)), 0, INT64_MIN);
  };
  EXPECT_FALSE(refused(steps));
  EXPECT_FALSE(ReadSteps(ContentOf(PackSteps(steps, 7)), 8, INT64_MIN)) << "one is missing";
  EXPECT_FALSE(ReadSteps(ContentOf(PackSteps(steps, 0)), 0, steps[0].time_ns)) << "time stands";
  auto wrong = steps;
  std::swap(wrong[1], wrong[2]);
  EXPECT_TRUE(refused(wrong)) << "time back";
  for (const double value : {std::nan(""), HUGE_VAL, 1e9}) {
    wrong = steps;
    wrong[1].breath.level = value;
    EXPECT_TRUE(refused(wrong));
    wrong = steps;
    wrong[2].probe.reference_from_tool =
        transforms::Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, value, 0.0));
    EXPECT_TRUE(refused(wrong));
  }
  wrong = steps;
  wrong[0].gain_db = -HUGE_VAL;
  EXPECT_TRUE(refused(wrong));
}

TEST(ImageProtocol, ATableOfOtherColumnsHoldsNoSteps) {
  const auto steps = SomeSteps(3);
  auto table = tracking::ReadTable(ContentOf(PackSteps(steps, 0)));
  ASSERT_TRUE(table);
  const auto packed = [&] { return tracking::PackTable("x", steps.back().time_ns, *table); };
  EXPECT_TRUE(ReadSteps(ContentOf(packed()), 0, INT64_MIN));
  table->columns *= 3;  // The same numbers in one row.
  EXPECT_FALSE(ReadSteps(ContentOf(packed()), 0, INT64_MIN));
  EXPECT_FALSE(ReadSteps({}, 0, INT64_MIN));
}

/// Any byte of a message changed at random, its checksum put right again.
TEST(ImageProtocol, FlippedBytesAreNoStepsOrStepsInBounds) {
  RandomStream random(6, "flips");
  const Bytes right = PackSteps(SomeSteps(4), 0);
  int read = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    Bytes content(ContentOf(right).begin(), ContentOf(right).end());
    for (int flips = 0; flips < 1 + trial % 3; ++flips) {
      content[random.Next() % content.size()] ^= static_cast<std::uint8_t>(1U << random.Next() % 8);
    }
    if (trial % 5 == 0) content.resize(random.Next() % content.size());
    const auto steps = ReadSteps(content, 0, INT64_MIN);
    if (!steps) continue;
    ++read;
    for (const StepInput& step : *steps) {
      EXPECT_TRUE(step.needle.reference_from_tool.matrix().allFinite());
      EXPECT_LT(step.probe.reference_from_tool.matrix().cwiseAbs().maxCoeff(), 1e6 + 1);
      EXPECT_TRUE(std::isfinite(step.breath.level_per_s));
    }
  }
  EXPECT_GT(read, 100) << "most flips are of the last digits";
  EXPECT_LT(read, 19'000);
}

class ImageMessages : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "ultrasound": {}, "ct_slice": {}, "fluoroscopy": {}})");
  }
  simulation::Scene Load(const std::vector<scenario::Override>& changes = {}) {
    scenario_ = scenario::ReadScenario(folder_ / "scene.json", changes);
    const auto plan = simulation::PlanEffects(
        scenario_, {.needle_poses = true, .probe_poses = true, .breath = true});
    return simulation::LoadScene(scenario_, plan, context_);
  }
  std::string Digest(const std::vector<scenario::Override>& changes = {}) {
    const simulation::Scene scene = Load(changes);
    return DigestOf(scenario_, scene);
  }
  scenario::Scenario scenario_;
};

TEST_F(ImageMessages, AMomentIsPutTogetherAgainAndWhatHasNotChangedIsNotSent) {
  const simulation::Scene scene = Load();
  ASSERT_EQ(ImageNames(scene), (std::vector<std::string>{"Ultrasound", "CtSlice", "fluoroscopy"}));
  LiveImage image;
  image.probe = std::make_shared<const acoustics::Probe>(*scene.probe);
  image.time_ns = 7'000'000'001;
  image.images.b_mode = {3, 2, {1, 2, 3, 4, 5, 6}};
  image.images.ct_slice = {2, 1, {7, 8}};
  image.effects.resize(1);
  image.effects[0].pixels.colour = {1, 2, {9, 10, 11, 12, 13, 14}};
  MomentPacker packer(scene);
  MomentReader reader(scene);
  const auto pass = [&](std::size_t num_messages) {
    const auto messages = packer.Pack(image);
    EXPECT_EQ(messages.size(), num_messages);
    for (const Bytes& message : messages) {
      EXPECT_FALSE(reader.TakeWhole());
      const auto header =
          tracking::ParseHeader(ByteView(message).first(tracking::kIgtlHeaderBytes));
      ASSERT_TRUE(header);
      EXPECT_TRUE(reader.Take(*header, ContentOf(message))) << header->device;
    }
    EXPECT_TRUE(reader.TakeWhole());
    EXPECT_EQ(reader.images().time_ns, image.time_ns);
    EXPECT_EQ(reader.images().images.b_mode.pixels, image.images.b_mode.pixels);
    EXPECT_EQ(reader.images().images.ct_slice.width, 2);
    EXPECT_EQ(reader.images().images.ct_slice.pixels, image.images.ct_slice.pixels);
    EXPECT_EQ(reader.images().effects.at(0).colour.rgb, image.effects[0].pixels.colour.rgb);
  };
  pass(4);
  image.time_ns += 1;
  image.images.b_mode.pixels[2] = 99;
  pass(2);
  EXPECT_EQ(reader.images().number, 2);

  const auto takes = [&](const Bytes& message) {
    const auto header = tracking::ParseHeader(ByteView(message).first(tracking::kIgtlHeaderBytes));
    return header && reader.Take(*header, ContentOf(message));
  };
  EXPECT_FALSE(takes(packer.Pack(image).back())) << "the same moment again";
  EXPECT_FALSE(takes(tracking::PackImage("Other", 1, {.width = 1, .height = 1, .pixels = {1}})));
  EXPECT_FALSE(takes(tracking::PackImage(
      "Ultrasound", 1, {.width = 1, .height = 1, .channels = 3, .pixels = {1, 2, 3}})));
  EXPECT_FALSE(takes(PackSteps(SomeSteps(1), 0)));
}

TEST_F(ImageMessages, TheDigestIsOfContentsAndSettingsNotOfPlaces) {
  const std::string digest = Digest();
  EXPECT_EQ(digest.size(), 64U);
  std::filesystem::create_directories(folder_ / "elsewhere");
  for (const char* file : {"ct.nrrd", "labels.seg.nrrd"}) {
    std::filesystem::copy(folder_ / file, folder_ / "elsewhere" / file);
  }
  const std::vector<scenario::Override> elsewhere = {
      {"/patient/ct", (folder_ / "elsewhere/ct.nrrd").string()},
      {"/patient/labels", (folder_ / "elsewhere/labels.seg.nrrd").string()}};
  EXPECT_EQ(Digest(elsewhere), digest);
  EXPECT_NE(Digest({{"/effects/ultrasound/model", "beams"}}), digest);
  EXPECT_NE(Digest({{"/image_rate_hz", 10}}), digest);
  EXPECT_NE(Digest({{"/effects/fluoroscopy", nullptr}}), digest);
  EXPECT_NE(Digest({{"/probe", "probes/curvilinear_c5.json"}}), digest);
  std::string ct = ReadTextFile(folder_ / "elsewhere/ct.nrrd");
  ct.back() = static_cast<char>(ct.back() ^ 1);
  WriteTextFile(folder_ / "elsewhere/ct.nrrd", ct);
  EXPECT_NE(Digest(elsewhere), digest);
}

}  // namespace
}  // namespace acus::live
