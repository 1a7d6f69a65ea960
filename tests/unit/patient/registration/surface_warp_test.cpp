#include "acus/patient/registration/surface_warp.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/mesh/nearest_triangle.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/registration/warp_volume.h"
#include "support/bumpy_surface.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// The trunk with a spine: bone in a tube along z, off the middle.
struct Patient {
  volume::CtVolume ct;
  volume::LabelMap labels;
  mesh::Surface skin = testing_support::Trunk(80, 120);
};

Patient MakePatient() {
  Patient patient;
  volume::Geometry geometry;
  geometry.size = {66, 48, 84};
  geometry.spacing_mm.setConstant(5.0);
  geometry.origin_mm = {-162.5, -117.5, -207.5};
  patient.ct = volume::CtVolume(geometry, -1000);
  patient.labels = volume::LabelMap(geometry);
  patient.labels.names = {{5, "bone"}, {volume::LabelOf("soft_tissue"), "soft_tissue"}};
  for (int k = 0; k < 84; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 66; ++i) {
        const Vector3d x_mm = geometry.ct_from_index() * Vector3d(i, j, k);
        // The surface is star-shaped about the origin: compare in the direction of x.
        const Vector3d unit(x_mm.x() / 150, x_mm.y() / 100, x_mm.z() / 200);
        const double latitude = std::asin(std::clamp(unit.z() / (unit.norm() + 1e-9), -1.0, 1.0));
        const double longitude = std::atan2(unit.y(), unit.x());
        if (x_mm.norm() > testing_support::TrunkPlace(latitude, longitude).norm()) continue;
        const bool bone = std::hypot(x_mm.x(), x_mm.y() + 50) < 18 && std::abs(x_mm.z()) < 150;
        patient.ct.At(i, j, k) = bone ? 700 : 40;
        patient.labels.At(i, j, k) = bone ? 5 : volume::LabelOf("soft_tissue");
      }
    }
  }
  return patient;
}

/// A fatter mannequin: belly 18 mm further out, flanks in, smoothly.
Vector3d Fattened(const Vector3d& x_mm) {
  const double front = std::exp(-((x_mm - Vector3d(0, 110, -20)) / 90).squaredNorm());
  return x_mm + Vector3d(-8 * std::sin(x_mm.x() / 110) * std::cos(x_mm.z() / 150), 18 * front, 0);
}

MannequinSkin Mannequin(int count, double sd_mm, bool with_normals = false) {
  MannequinSkin skin;
  skin.points_mm.resize(3, count);
  RandomStream random(5, "mannequin");
  for (Eigen::Index i = 0; i < count; ++i) {
    const double latitude = std::asin(random.Uniform(-0.95, 0.95));
    skin.points_mm.col(i) =
        Fattened(testing_support::TrunkPlace(latitude, random.Uniform(0, 6.2832))) +
        sd_mm * Vector3d(random.Normal(), random.Normal(), random.Normal());
  }
  if (with_normals) skin.normals = skin.points_mm.colwise().normalized();
  return skin;
}

WarpSettings Coarse() {
  WarpSettings settings;
  settings.lattice_mm = 16.0;
  settings.num_rounds = 6;
  settings.most_points = 2500;
  return settings;
}

// A known warp of the skin: the skin arrives, nothing folds, bone stays rigid, and the field goes
// back.
TEST(WarpToMannequin, CarriesTheSkinAndKeepsBoneRigid) {
  const Patient patient = MakePatient();
  const SurfaceWarp warp =
      WarpToMannequin(patient.labels, patient.skin, Mannequin(2500, 0.0), Coarse(), RunContext{});
  const WarpQuality& q = warp.quality;
  EXPECT_GT(q.before_rms_mm, 3.5);
  EXPECT_LT(q.after_rms_mm, 0.35);
  EXPECT_LT(q.after_p95_mm, 0.8);
  EXPECT_GT(q.smallest_volume, 0.5);
  EXPECT_LT(q.largest_volume, 1.8);
  EXPECT_LT(q.bone_strain, 0.02);
  EXPECT_LT(q.bone_rms_mm, 0.3);
  EXPECT_GT(q.largest_mm, 12.0);
  // Decays with depth: half way to the spine it is less than at the skin.
  const double skin_mm = warp.field.At({0, 100, -20}).norm();
  EXPECT_GT(skin_mm, 12.0);
  EXPECT_LT(warp.field.At({0, 20, -20}).norm(), 0.75 * skin_mm);
  EXPECT_LT(warp.field.At({0, -50, -20}).norm(), 0.35 * skin_mm);
}

TEST(WarpToMannequin, IsJudgedByWhatIsLeftAfterTheLastRound) {
  const Patient patient = MakePatient();
  WarpSettings settings = Coarse();
  settings.num_rounds = 1;
  settings.lattice_mm = 25.0;
  settings.most_points = 800;
  const WarpQuality q =
      WarpToMannequin(patient.labels, patient.skin, Mannequin(800, 0.0), settings, RunContext{})
          .quality;
  EXPECT_LT(q.after_rms_mm, 0.5 * q.before_rms_mm);
}

TEST(WarpToMannequin, SmoothsNoiseAndPassesOverWhatIsNotSkin) {
  const Patient patient = MakePatient();
  MannequinSkin mannequin = Mannequin(2500, 0.7, true);
  for (Eigen::Index i = 0; i < 2500; i += 20) {
    mannequin.points_mm.col(i) *= 1.9;  // A table and arms.
    mannequin.normals.col(i + 1) *= -1;
  }
  const SurfaceWarp warp =
      WarpToMannequin(patient.labels, patient.skin, mannequin, Coarse(), RunContext{});
  EXPECT_GE(warp.quality.num_left_out, 240);
  EXPECT_LT(warp.quality.num_left_out, 420);
  // Against the exact skin the noise is averaged out.
  mesh::Surface warped = patient.skin;
  for (Eigen::Index i = 0; i < warped.nodes_mm.cols(); ++i) {
    warped.nodes_mm.col(i) += warp.field.At(patient.skin.nodes_mm.col(i));
  }
  const mesh::NearestTriangle nearest(warped);
  const MannequinSkin exact = Mannequin(2500, 0.0);
  double sum_mm2 = 0.0;
  for (Eigen::Index i = 0; i < 2500; ++i) {
    sum_mm2 += nearest.Find(exact.points_mm.col(i)).squared_mm2 / 2500;
  }
  EXPECT_LT(std::sqrt(sum_mm2), 0.6);
}

TEST(WarpToMannequin, DoesNothingForItsOwnShape) {
  const Patient patient = MakePatient();
  MannequinSkin own;
  own.points_mm = patient.skin.nodes_mm;
  const auto warp = WarpToMannequin(patient.labels, patient.skin, own, Coarse(), RunContext{});
  EXPECT_LT(warp.quality.largest_mm, 1e-6);
  EXPECT_NEAR(warp.quality.smallest_volume, 1.0, 1e-6);
}

TEST(WarpToMannequin, SaysWhenItCannotWork) {
  const Patient patient = MakePatient();
  MannequinSkin far = Mannequin(500, 0.0);
  far.points_mm.row(0).array() += 300.0;
  EXPECT_THAT([&] { WarpToMannequin(patient.labels, patient.skin, far, Coarse(), RunContext{}); },
              ThrowsMessage<NoAnswerError>(HasSubstr("is the registration right?")));
  WarpSettings settings = Coarse();
  settings.smallest_volume = 0.99;
  settings.num_rounds = 2;
  EXPECT_THAT(
      [&] {
        WarpToMannequin(patient.labels, patient.skin, Mannequin(500, 0.0), settings, RunContext{});
      },
      ThrowsMessage<NoAnswerError>(HasSubstr("it folds")));
  const auto refused = [&](auto change) {
    WarpSettings bad = Coarse();
    change(bad);
    EXPECT_THROW(
        WarpToMannequin(patient.labels, patient.skin, Mannequin(500, 0.0), bad, RunContext{}),
        InputError);
  };
  using S = WarpSettings;
  refused([](S& s) { s.lattice_mm = 1.9; });
  refused([](S& s) { s.lattice_mm = 51; });
  refused([](S& s) { s.reach_mm = 0; });
  refused([](S& s) { s.bone_modulus = 0.9; });
  refused([](S& s) { s.air_modulus = 0; });
  refused([](S& s) { s.air_modulus = 1.1; });
  refused([](S& s) { s.compliance_mm = 0; });
  refused([](S& s) { s.num_rounds = 0; });
  refused([](S& s) { s.most_points = 99; });
  refused([](S& s) { s.smallest_volume = 1; });
  EXPECT_THROW(
      WarpToMannequin(patient.labels, patient.skin, Mannequin(99, 0.0), Coarse(), RunContext{}),
      InputError);
}

TEST(WarpVolume, ShowsTheTissueWhereItWent) {
  const Patient patient = MakePatient();
  WarpSettings quick = Coarse();
  quick.num_rounds = 2;
  const auto warp =
      WarpToMannequin(patient.labels, patient.skin, Mannequin(800, 0.0), quick, RunContext{});
  const auto labels = WarpLabels(patient.labels, warp.field, RunContext{});
  const auto ct = WarpCt(patient.ct, warp.field, RunContext{});
  ASSERT_TRUE(ct.geometry.Matches(labels.geometry));
  EXPECT_GT(ct.geometry.size[1], patient.ct.geometry.size[1]);
  int wrong = 0, looked = 0;
  for (int k = 4; k < 80; k += 3) {
    for (int j = 4; j < 44; j += 3) {
      for (int i = 4; i < 62; i += 3) {
        const Vector3d rest_mm = patient.ct.geometry.ct_from_index() * Vector3d(i, j, k);
        const Vector3d at = labels.geometry.index_from_ct() * (rest_mm + warp.field.At(rest_mm));
        const Eigen::Array3i near = at.array().round().cast<int>();
        ASSERT_TRUE(labels.geometry.Contains(near[0], near[1], near[2]));
        ++looked;
        wrong += labels.At(near[0], near[1], near[2]) != patient.labels.At(i, j, k);
      }
    }
  }
  EXPECT_LT(wrong, 0.06 * looked);  // Voxels of 5 mm at borders.
  EXPECT_EQ(ct.At(0, 0, 0), -1024);
  const auto file = ToDisplacementField(warp.field);
  EXPECT_EQ(file.displacement_in_ct_mm.size(), 3 * warp.field.nodes_mm().size());
}

}  // namespace
}  // namespace acus::registration
