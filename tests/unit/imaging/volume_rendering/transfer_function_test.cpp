#include "acus/imaging/volume_rendering/transfer_function.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<OpacityNode> Ramp() {
  return {{100, 0.0, {1, 0, 0}}, {200, 2.0, {1, 0, 0}}, {300, 2.0, {0, 1, 0}}};
}

TEST(TransferFunction, AveragesOverAPieceOfRay) {
  const TransferFunction transfer(Ramp());
  // The mean of a ramp from 0 to 2, whichever way it is run through.
  EXPECT_NEAR(transfer.Between(100, 200)[3], 1.0, 1e-3);
  EXPECT_NEAR(transfer.Between(200, 100)[3], 1.0, 1e-3);
  EXPECT_NEAR(transfer.Between(250, 250)[3], 2.0, 1e-3);
  // Colour counts by its opacity.
  EXPECT_NEAR(transfer.Between(200, 300)[0], 1.0, 2e-2);
  EXPECT_NEAR(transfer.Between(200, 300)[1], 1.0, 2e-2);
  // A thin layer between two samples is not missed: 1 HU is worth 1 / 1000 of the way.
  EXPECT_NEAR(transfer.Between(-900, 100)[3], 0.0, 1e-6);
  EXPECT_NEAR(transfer.Between(-800, 200)[3], 0.1, 1e-3);
}

TEST(TransferFunction, KnowsWhatShows) {
  const TransferFunction transfer(Ramp());
  EXPECT_FALSE(transfer.Shows(-1024, 100));
  EXPECT_TRUE(transfer.Shows(-1024, 103));
  EXPECT_TRUE(transfer.Shows(1000, 30000));  // Beyond the last node as there.
  EXPECT_TRUE(TransferFunction{}.empty());
}

TEST(TransferFunction, PresetsShowTheirTissue) {
  const auto shown = [](const char* preset, float hu) {
    const VolumeLayer layer{preset, 1.0};
    return TransferFunction(std::span(&layer, 1)).Between(hu, hu)[3] > 0.0F;
  };
  EXPECT_TRUE(shown("skin", -200));
  EXPECT_FALSE(shown("skin", -900));
  EXPECT_TRUE(shown("bone", 700));
  EXPECT_FALSE(shown("bone", 60));
  EXPECT_TRUE(shown("soft_tissue", 50));
  EXPECT_FALSE(shown("soft_tissue", -100));
  EXPECT_TRUE(shown("vessels", 200));
  EXPECT_FALSE(shown("vessels", 60));
}

TEST(TransferFunction, LayersAddUpByTheirOpacity) {
  const std::vector<VolumeLayer> layers = {{"bone", 0.5}, {"vessels", 0.25}, {"skin", 0.0}};
  const VolumeLayer bone{"bone", 1.0};
  const VolumeLayer vessels{"vessels", 1.0};
  const float sum = TransferFunction(layers).Between(500, 500)[3];
  EXPECT_NEAR(sum,
              0.5 * TransferFunction(std::span(&bone, 1)).Between(500, 500)[3] +
                  0.25 * TransferFunction(std::span(&vessels, 1)).Between(500, 500)[3],
              1e-5);
  EXPECT_EQ(TransferFunction(layers).Between(-200, -200)[3], 0.0F);
}

// Presets are files; their nodes are those that images have always had.
TEST(TransferFunction, APresetIsItsFile) {
  const VolumeLayer bone{"bone", 1.0};
  const std::vector<OpacityNode> nodes = {{170, 0.0, {0.85F, 0.72F, 0.55F}},
                                          {280, 0.35, {0.92F, 0.84F, 0.70F}},
                                          {600, 1.6, {0.97F, 0.94F, 0.86F}},
                                          {1500, 2.5, {1.0F, 1.0F, 0.97F}}};
  const TransferFunction from_file(std::span(&bone, 1));
  const TransferFunction from_nodes(nodes);
  for (float hu = -1000.0F; hu < 3000.0F; hu += 7.0F) {
    EXPECT_TRUE((from_file.Between(hu, hu + 90.0F) == from_nodes.Between(hu, hu + 90.0F)).all());
  }
}

// "liver" holds in the liver only; "bone" everywhere, there too.
TEST(TransferFunction, LayersOfTissuesHoldInTheirClasses) {
  const std::vector<VolumeLayer> layers = {{"liver", 1.0}, {"bone", 1.0}};
  const TransferFunction transfer(layers);
  ASSERT_TRUE(transfer.has_classes());
  const int liver = transfer.class_of_label()[volume::LabelOf("liver")];
  EXPECT_EQ(liver, 1);
  EXPECT_EQ(transfer.class_of_label()[volume::LabelOf("muscle")], 0);
  EXPECT_GT(transfer.Between(100, 100, liver)[3], 0.0F);
  EXPECT_EQ(transfer.Between(100, 100, 0)[3], 0.0F);
  EXPECT_GT(transfer.Between(700, 700, 0)[3], 0.0F);
  EXPECT_GT(transfer.Between(700, 700, liver)[3], transfer.Between(700, 700, 0)[3]);
  EXPECT_FALSE(transfer.Shows(50, 120, 1U));
  EXPECT_TRUE(transfer.Shows(50, 120, 1U | 1U << 1U));
  // One that is not shown makes no class.
  const std::vector<VolumeLayer> without = {{"liver", 0.0}, {"bone", 1.0}};
  EXPECT_FALSE(TransferFunction(without).has_classes());
}

// All zeros: nothing shows, and nothing fails.
TEST(TransferFunction, OfZerosShowsNothing) {
  const std::vector<OpacityNode> nodes = {{0, 0.0, {1, 1, 1}}, {100, 0.0, {1, 1, 1}}};
  const TransferFunction zeros(nodes);
  EXPECT_TRUE(zeros.empty());
  EXPECT_FALSE(zeros.Shows(-1024, 3071));
}

TEST(TransferFunction, RefusesWhatIsWrong) {
  const VolumeLayer fog{"fog", 1.0};
  EXPECT_THAT([&] { TransferFunction{std::span(&fog, 1)}; },
              ThrowsMessage<InputError>(HasSubstr("skin, soft_tissue, vessels")));
  for (const double opacity : {-0.1, 1.1, std::nan("")}) {
    const VolumeLayer layer{"bone", opacity};
    EXPECT_THAT([&] { TransferFunction{std::span(&layer, 1)}; },
                ThrowsMessage<InputError>(HasSubstr("opacity")));
  }
  const auto broken = [](auto change) {
    return [change] {
      std::vector<OpacityNode> nodes = Ramp();
      change(nodes);
      TransferFunction{nodes};
    };
  };
  EXPECT_THAT(broken([](auto& n) { n.resize(1); }), ThrowsMessage<InputError>(HasSubstr("two")));
  EXPECT_THAT(broken([](auto& n) { n[1].hu = 100; }),
              ThrowsMessage<InputError>(HasSubstr("does not lie above")));
  EXPECT_THAT(broken([](auto& n) { n[1].extinction_per_mm = -1; }),
              ThrowsMessage<InputError>(HasSubstr("extinction")));
  EXPECT_THAT(broken([](auto& n) { n[1].extinction_per_mm = 101; }),
              ThrowsMessage<InputError>(HasSubstr("extinction")));
  EXPECT_THAT(broken([](auto& n) { n[2].hu = std::nan(""); }),
              ThrowsMessage<InputError>(HasSubstr("finite")));
}

}  // namespace
}  // namespace acus::volume_rendering
