#include "acus/patient/segmentation/segmenters/organ_vessels.h"

#include <algorithm>
#include <array>
#include <gmock/gmock.h>

#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/line_filter.h"
#include "acus/patient/segmentation/voxels/metrics.h"

namespace acus::segmentation {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

struct LiverOptions {
  Eigen::Array3d spacing_mm = {0.9, 0.9, 1.5};
  double vessel_hu = 160.0;  ///< The liver has 110.
  double noise_hu = 18.0;    ///< After a blur, as the kernel of a scanner leaves it.
  double half_width_mm = 45.0;
  bool has_tumour = false;
  double slope_hu_per_mm = 0.0;  ///< Along x.
};

struct LiverOfTubes {
  volume::CtVolume ct;
  Mask organ, vessels, tumour;
};

/// Branches in a plane that is tilted against the grid, and some across; radii of 1.6 to 5 mm.
struct Branch {
  Vector3d from_mm, to_mm;
  double radius_mm;
  double DistanceMm(const Vector3d& p) const {
    const Vector3d axis = to_mm - from_mm;
    const double t = std::clamp((p - from_mm).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    return (p - from_mm - t * axis).norm() - radius_mm;
  }
};
const std::array kBranches = {
    Branch{{0, -34, -8}, {0, 0, 0}, 5.0},     Branch{{0, 0, 0}, {-28, 12, 8}, 3.5},
    Branch{{0, 0, 0}, {26, 14, -6}, 3.5},     Branch{{-14, 6, 4}, {-24, 28, -6}, 2.2},
    Branch{{13, 7, -3}, {12, 30, 6}, 2.2},    Branch{{20, 11, -5}, {36, -6, 6}, 1.8},
    Branch{{-20, 9, 6}, {-34, -8, -4}, 1.8},  Branch{{-4, -20, -5}, {-22, -26, 10}, 1.6},
    Branch{{4, -22, -5}, {24, -24, -12}, 1.6}};

LiverOfTubes MakeLiver(const LiverOptions& options) {
  volume::Geometry g;
  g.spacing_mm = options.spacing_mm;
  const Eigen::Array3d half_mm(options.half_width_mm, 48.0, 26.0);
  g.size = (2.0 * half_mm / g.spacing_mm).floor().cast<int>() + 1;
  g.origin_mm = (-0.5 * (g.size - 1).cast<double>() * g.spacing_mm).matrix();
  volume::Grid<float> noise(g), hu(g, 40.0F);
  RandomStream random(11, "noise", 0);
  for (float& value : noise.voxels) value = static_cast<float>(random.Normal());
  noise = Blurred(noise, 0.7 * g.spacing_mm[0], 2);
  double square = 0.0;
  for (const float value : noise.voxels) square += value * value;
  const double scale =
      options.noise_hu / std::sqrt(square / static_cast<double>(noise.voxels.size()));
  LiverOfTubes liver{volume::CtVolume(g), Mask(g), Mask(g), Mask(g)};
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const std::size_t n = g.Index(i, j, k);
        const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
        const bool in_organ = (p.array() / Eigen::Array3d(43, 42, 23)).matrix().norm() < 1.0;
        if (!in_organ) continue;
        liver.organ.voxels[n] = 1;
        hu.voxels[n] = static_cast<float>(110.0 + options.slope_hu_per_mm * p.x());
        if (options.has_tumour && (p - Vector3d(8, -10, 8)).norm() < 9.0) {
          liver.tumour.voxels[n] = 1;
          hu.voxels[n] = 65.0F;
        }
        const bool in_vessel = std::ranges::any_of(
            kBranches, [&](const Branch& branch) { return branch.DistanceMm(p) < 0.0; });
        if (!in_vessel) continue;
        liver.vessels.voxels[n] = 1;
        hu.voxels[n] = static_cast<float>(options.vessel_hu);
      }
    }
  }
  hu = Blurred(hu, 0.7, 2);
  for (std::size_t n = 0; n < hu.voxels.size(); ++n) {
    const double value = hu.voxels[n] + scale * noise.voxels[n];
    liver.ct.voxels[n] = static_cast<std::int16_t>(std::lround(value));
  }
  return liver;
}

/// Dice of the vessels in a liver. @pre they are found.
double DiceIn(const LiverOfTubes& liver) {
  const OrganVessels found = FindVesselsIn(liver.ct, liver.organ, 2);
  EXPECT_TRUE(found.is_found) << found.reason;
  const double dice = Dice(found.vessels, liver.vessels);
  std::cout << "Dice " << dice << ", " << found.vessel_ml << " ml at " << found.vessel_hu
            << " HU; bright " << found.bright_ml << " ml, dark " << found.dark_ml << " ml\n";
  return dice;
}

TEST(OrganVessels, AreFoundByTheirContrast) {
  const LiverOfTubes liver = MakeLiver({});
  EXPECT_GT(DiceIn(liver), 0.85);
  const OrganVessels found = FindVesselsIn(liver.ct, liver.organ, 2);
  EXPECT_NEAR(found.organ_hu, 110.0, 4.0);
  EXPECT_NEAR(found.noise_hu, 18.0, 4.0);
  EXPECT_NEAR(found.vessel_hu, 160.0, 12.0);
}

TEST(OrganVessels, AreFoundOnCoarseAndUnevenVoxels) {
  EXPECT_GT(DiceIn(MakeLiver({.spacing_mm = {0.8, 0.8, 3.0}})), 0.70);
  EXPECT_GT(DiceIn(MakeLiver({.spacing_mm = {2.0, 2.0, 2.0}})), 0.65);
}

TEST(OrganVessels, AreFoundInNoiseTumoursUnevenContrastAndWhereTheFieldCutsTheOrgan) {
  EXPECT_GT(DiceIn(MakeLiver({.noise_hu = 35.0})), 0.70);
  EXPECT_GT(DiceIn(MakeLiver({.has_tumour = true})), 0.80);
  EXPECT_GT(DiceIn(MakeLiver({.slope_hu_per_mm = 0.4})), 0.80);
  EXPECT_GT(DiceIn(MakeLiver({.half_width_mm = 22.0})), 0.80);
}

TEST(OrganVessels, AreNotFoundWhereTheyAreNot) {
  for (const double noise_hu : {6.0, 18.0, 40.0}) {
    // As dense as the liver; darker, as without contrast agent; brighter by less than noise shows.
    for (const double vessel_hu : {110.0, 92.0, 112.0}) {
      const LiverOfTubes liver = MakeLiver({.vessel_hu = vessel_hu, .noise_hu = noise_hu});
      const OrganVessels found = FindVesselsIn(liver.ct, liver.organ, 2);
      EXPECT_FALSE(found.is_found) << noise_hu << ", " << vessel_hu;
      EXPECT_THAT(found.reason, HasSubstr("contrast agent"));
      EXPECT_EQ(Count(found.vessels), 0U);
    }
  }
}

TEST(OrganVessels, ThatWouldBeAFifthOfTheOrganAreRefused) {
  LiverOfTubes liver = MakeLiver({.vessel_hu = 110.0, .noise_hu = 5.0});
  // Columns along k, 4.5 mm wide.
  for (std::size_t n = 0; n < liver.ct.voxels.size(); ++n) {
    const auto i = n % liver.ct.geometry.Index(0, 1, 0);
    const auto j = n % liver.ct.geometry.Index(0, 0, 1) / liver.ct.geometry.Index(0, 1, 0);
    if (liver.organ.voxels[n] != 0 && i % 11 < 5 && j % 11 < 5) liver.ct.voxels[n] += 60;
  }
  const OrganVessels found = FindVesselsIn(liver.ct, liver.organ, 2);
  EXPECT_FALSE(found.is_found);
  EXPECT_THAT(found.reason, HasSubstr("% of the organ would be vessel; at most 15 %"));
}

TEST(OrganVessels, OfNoOrganAreNone) {
  const LiverOfTubes liver = MakeLiver({});
  EXPECT_EQ(FindVesselsIn(liver.ct, Mask(liver.ct.geometry), 1).reason, "the organ is empty");
  volume::Geometry other = liver.ct.geometry;
  other.origin_mm.x() += 3.0;
  EXPECT_THROW(FindVesselsIn(liver.ct, Mask(other, 1), 1), InputError);
}

TEST(OrganVessels, HaveTheSameBitsForAnyNumberOfThreads) {
  const LiverOfTubes liver = MakeLiver({});
  EXPECT_EQ(FindVesselsIn(liver.ct, liver.organ, 1).vessels.voxels,
            FindVesselsIn(liver.ct, liver.organ, 3).vessels.voxels);
}

TEST(LiverVessels, TakeThePlaceOfLiverAndOfSoftTissueThatItEncloses) {
  const LiverOfTubes liver = MakeLiver({.has_tumour = true});
  volume::LabelMap labels(liver.ct.geometry, volume::LabelOf("soft_tissue"));
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    if (liver.organ.voxels[n] != 0) labels.voxels[n] = volume::LabelOf("liver");
    // As labels of the liver often are: without its larger vessels.
    if (liver.vessels.voxels[n] != 0) labels.voxels[n] = volume::LabelOf("soft_tissue");
    if (liver.tumour.voxels[n] != 0) labels.voxels[n] = volume::LabelOf("lesion");
  }
  const volume::LabelMap before = labels;
  EXPECT_THAT(AddLiverVessels(liver.ct, labels, {}), HasSubstr(" ml at about 15"));
  EXPECT_EQ(labels.names.at(volume::LabelOf("vessel")), "vessel");
  std::size_t both = 0;
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    const bool is_vessel = labels.voxels[n] == volume::LabelOf("vessel");
    both += is_vessel && liver.vessels.voxels[n] != 0 ? 1U : 0U;
    ASSERT_TRUE(is_vessel || labels.voxels[n] == before.voxels[n]);
    ASSERT_FALSE(is_vessel && liver.tumour.voxels[n] != 0);
  }
  EXPECT_GT(static_cast<double>(both), 0.75 * static_cast<double>(Count(liver.vessels)));
}

TEST(LiverVessels, NeedALiver) {
  const LiverOfTubes liver = MakeLiver({});
  volume::LabelMap labels(liver.ct.geometry, volume::LabelOf("soft_tissue"));
  EXPECT_THROW(AddLiverVessels(liver.ct, labels, {}), InputError);
}

}  // namespace
}  // namespace acus::segmentation
