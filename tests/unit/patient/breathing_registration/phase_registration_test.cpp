#include "acus/patient/breathing_registration/phase_registration.h"

#include <gmock/gmock.h>
#include <optional>

#include "acus/base/core/random.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/phantom/breath/breathing_scan.h"
#include "support/synthetic_trunk.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Vector3d;

/// The trunk with vessels: blobs of contrast in lung and liver, 14 mm apart.
volume::CtVolume TexturedTrunk(const volume::LabelMap& labels) {
  volume::CtVolume ct(labels.geometry);
  for (std::size_t v = 0; v < ct.voxels.size(); ++v) {
    const volume::Label label = labels.voxels[v];
    ct.voxels[v] = label == 0                         ? -1000
                   : label == volume::LabelOf("lung") ? -850
                   : label == volume::LabelOf("bone") ? 500
                   : label == volume::LabelOf("fat")  ? -100
                                                      : 40;
  }
  RandomStream random(5, "vessels");
  const volume::Geometry& g = labels.geometry;
  for (int n = 0; n < 2500; ++n) {
    const Eigen::Array3i c(static_cast<int>(random.Uniform(2, g.size[0] - 2)),
                           static_cast<int>(random.Uniform(2, g.size[1] - 2)),
                           static_cast<int>(random.Uniform(2, g.size[2] - 2)));
    const bool lung = labels.At(c[0], c[1], c[2]) == volume::LabelOf("lung");
    for (int a = 0; a < 8; ++a) {
      const std::size_t v = g.Index(c[0] + (a & 1), c[1] + ((a >> 1) & 1), c[2] + (a >> 2));
      if (labels.voxels[v] == labels.At(c[0], c[1], c[2]) && labels.voxels[v] != 0) {
        ct.voxels[v] = static_cast<std::int16_t>(ct.voxels[v] + (lung ? 500 : 110));
      }
    }
  }
  return ct;
}

struct Trunk {
  Trunk()
      : labels(testing_support::SyntheticTrunk()),
        ct(TexturedTrunk(labels)),
        motion(phantom::FindCavity(labels, {}),
               {.diaphragm_mm = 15.0, .chest_mm = 4.0, .hysteresis_mm = 0.0}) {
    tissue.is_tissue = [this](const Vector3d& p) {
      const Eigen::Array3i n = (labels.geometry.index_from_ct() * p).array().round().cast<int>();
      return labels.geometry.Contains(n[0], n[1], n[2]) && labels.At(n[0], n[1], n[2]) != 0;
    };
    tissue.wall_mm = [this](const Vector3d& p) { return motion.cavity().wall.LevelMm(p); };
    phase = phantom::ScanAt(ct, motion, {}, {.noise_sd_hu = 5.0}, {});
  }

  /// Errors at points of tissue in a layer about the wall, mm; from `low` to `high` mm from it.
  std::vector<double> Errors(const PhaseField& field, double low, double high,
                             std::optional<Side> only = {}) const {
    std::vector<double> errors_mm;
    RandomStream random(7, "points");
    while (errors_mm.size() < 200) {
      const Vector3d p(random.Uniform(-125, 125), random.Uniform(-90, 90),
                       random.Uniform(-90, 110));
      const double wall_mm = motion.cavity().wall.LevelMm(p);
      if (!tissue.is_tissue(p) || std::abs(wall_mm) < low || std::abs(wall_mm) > high) continue;
      const Side side = wall_mm < 0.0 ? Side::kCavity : Side::kWall;
      if (only && side != *only) continue;
      errors_mm.push_back((field.DisplacementMm(p, side) - (motion.WorldMm(p, {}) - p)).norm());
    }
    return errors_mm;
  }

  volume::LabelMap labels;
  volume::CtVolume ct, phase;
  phantom::BreathingMotion motion;
  Tissue tissue;
};

const Trunk& TheTrunk() {
  static const Trunk trunk;
  return trunk;
}

const RegistrationSettings kCoarse{.spacing_mm = 4.0, .smoothness = 0.8};

TEST(PhaseRegistration, FindsAKnownMotion) {
  const Trunk& trunk = TheTrunk();
  const PhaseRegistration registration(trunk.ct, trunk.tissue, kCoarse, {});
  Residual residual;
  const PhaseField field = registration.Register(trunk.phase, nullptr, {}, &residual);
  EXPECT_LT(residual.after, 0.5 * residual.before);
  // Within the cavity: outside of the ribs there is a layer of fat and skin of 20 mm, almost
  // without texture, that breath moves along itself.
  const auto errors = trunk.Errors(field, 10.0, 60.0, Side::kCavity);
  EXPECT_LT(math::Mean(errors), 1.0);
  EXPECT_LT(math::Quantile(errors, 0.95), 2.5);
}

TEST(PhaseRegistration, SlidingIsBetterThanNoneAtTheWall) {
  const Trunk& trunk = TheTrunk();
  const auto near_wall = [&](const Tissue& tissue) {
    const PhaseRegistration registration(trunk.ct, tissue, kCoarse, {});
    return math::Mean(trunk.Errors(registration.Register(trunk.phase, nullptr, {}), 0.0, 8.0));
  };
  EXPECT_LT(near_wall(trunk.tissue), 0.75 * near_wall({trunk.tissue.is_tissue, {}}));
}

/// Share of the errors at points of tissue that keep to the bound, and the bounds' mean.
struct Kept {
  double share = 0.0, mean_bound_mm = 0.0;
};

Kept KeptBy(const Trunk& trunk, const PhaseField& field, double low, double high) {
  Kept kept;
  RandomStream random(11, "bounded points");
  constexpr int kCount = 2000;
  for (int n = 0; n < kCount;) {
    const Vector3d p(random.Uniform(-125, 125), random.Uniform(-90, 90), random.Uniform(-90, 110));
    const double wall_mm = trunk.motion.cavity().wall.LevelMm(p);
    if (!trunk.tissue.is_tissue(p) || std::abs(wall_mm) < low || std::abs(wall_mm) > high) continue;
    const Side side = wall_mm < 0.0 ? Side::kCavity : Side::kWall;
    const double error = (field.DisplacementMm(p, side) - (trunk.motion.WorldMm(p, {}) - p)).norm();
    kept.share += (error <= field.BoundMm(p, side) ? 1.0 : 0.0) / kCount;
    kept.mean_bound_mm += field.BoundMm(p, side) / kCount;
    ++n;
  }
  return kept;
}

TEST(PhaseRegistration, ItsErrorKeepsToTheBound) {
  const Trunk& trunk = TheTrunk();
  const PhaseRegistration registration(trunk.ct, trunk.tissue, kCoarse, {});
  const PhaseField field = registration.Register(trunk.phase, nullptr, {});
  const Kept all = KeptBy(trunk, field, 0.0, 60.0), sliding = KeptBy(trunk, field, 0.0, 8.0);
  RecordProperty("kept", std::to_string(all.share));
  RecordProperty("kept_sliding", std::to_string(sliding.share));
  RecordProperty("mean_bound_mm", std::to_string(all.mean_bound_mm));
  EXPECT_GT(all.share, 0.93);
  EXPECT_LT(all.share, 0.97);
  EXPECT_GT(sliding.share, 0.93);
  // A bound that says nothing would keep everything.
  EXPECT_LT(all.mean_bound_mm, 4.0);
  EXPECT_GT(sliding.mean_bound_mm, all.mean_bound_mm);
}

TEST(PhaseRegistration, TheSameBitsOnAnyThreads) {
  const Trunk& trunk = TheTrunk();
  RunContext one, three;
  three.num_threads = 3;
  const PhaseRegistration a(trunk.ct, trunk.tissue, {.spacing_mm = 8.0}, one);
  const PhaseRegistration b(trunk.ct, trunk.tissue, {.spacing_mm = 8.0}, three);
  EXPECT_EQ(a.Register(trunk.phase, nullptr, one).displacement_voxels(),
            b.Register(trunk.phase, nullptr, three).displacement_voxels());
}

TEST(PhaseRegistration, AnImageIsWhereItIs) {
  const Trunk& trunk = TheTrunk();
  const PhaseRegistration registration(trunk.ct, trunk.tissue, {.spacing_mm = 8.0}, {});
  const PhaseField field = registration.Register(trunk.ct, nullptr, {});
  for (const auto& u : field.displacement_voxels()) EXPECT_LT(u.norm(), 1e-6);
}

TEST(DefaultSpacing, GrowsWithVoxelsAndWithTheTissue) {
  const Tissue all{[](const Vector3d&) { return true; }, {}};
  const auto spacing_mm = [&](int size, double voxel_mm, const Tissue& tissue) {
    volume::Geometry ct;
    ct.size = {size, size, size};
    ct.spacing_mm = Eigen::Array3d::Constant(voxel_mm);
    return DefaultSpacingMm(ct, tissue, 2);
  };
  EXPECT_DOUBLE_EQ(spacing_mm(100, 0.9, all), 2.0);
  EXPECT_DOUBLE_EQ(spacing_mm(80, 2.5, all), 2.5);
  // 512 mm each way: 134 l over 1.3 million nodes.
  const double large_mm = spacing_mm(257, 2.0, all);
  EXPECT_NEAR(large_mm, std::cbrt(520.0 * 520.0 * 520.0 / 1.3e6), 0.01);
  // An eighth of that in tissue: half the distance.
  const Tissue corner{[](const Vector3d& p) { return (p.array() < 256.0).all(); }, {}};
  EXPECT_NEAR(spacing_mm(257, 2.0, corner), std::max(2.0, 0.5 * large_mm), 0.05);
  const Tissue none{[](const Vector3d&) { return false; }, {}};
  EXPECT_DOUBLE_EQ(spacing_mm(100, 0.9, none), 2.0);
}

TEST(PhaseRegistration, RefusesOtherGrids) {
  const Trunk& trunk = TheTrunk();
  const PhaseRegistration registration(trunk.ct, trunk.tissue, {.spacing_mm = 8.0}, {});
  volume::CtVolume moved = trunk.phase;
  moved.geometry.origin_mm.x() += 1.0;
  EXPECT_THROW(registration.Register(moved, nullptr, {}), InputError);
  EXPECT_THROW(PhaseRegistration(trunk.ct, trunk.tissue, {.spacing_mm = 0.1}, {}), InputError);
  EXPECT_THROW(PhaseRegistration(trunk.ct, trunk.tissue, {.levels = 0}, {}), InputError);
  EXPECT_THROW(
      PhaseRegistration(trunk.ct, {[](const Vector3d&) { return false; }, {}}, kCoarse, {}),
      InputError);
}

}  // namespace
}  // namespace acus::breathing_registration
