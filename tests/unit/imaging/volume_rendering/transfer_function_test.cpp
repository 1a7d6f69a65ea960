#include "acus/imaging/volume_rendering/transfer_function.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<OpacityNode> Ramp() {
  return {{100, 0.0, {1, 0, 0}}, {200, 2.0, {1, 0, 0}}, {300, 2.0, {0, 1, 0}}};
}

TEST(TransferFunction, AveragesOverAPieceOfRay) {
  const TransferFunction transfer{std::span<const OpacityNode>(Ramp())};
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
  const TransferFunction transfer{std::span<const OpacityNode>(Ramp())};
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

TEST(TransferFunction, RefusesWhatIsWrong) {
  EXPECT_THAT([] { TransferPreset("fog"); },
              ThrowsMessage<InputError>(HasSubstr("skin, bone, soft_tissue, vessels")));
  for (const double opacity : {-0.1, 1.1, std::nan("")}) {
    const VolumeLayer layer{"bone", opacity};
    EXPECT_THAT([&] { TransferFunction{std::span(&layer, 1)}; },
                ThrowsMessage<InputError>(HasSubstr("opacity")));
  }
  const auto broken = [](auto change) {
    return [change] {
      std::vector<OpacityNode> nodes = Ramp();
      change(nodes);
      TransferFunction{std::span<const OpacityNode>(nodes)};
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
