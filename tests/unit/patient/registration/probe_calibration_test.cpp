#include "acus/patient/registration/probe_calibration.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/session/plus_config.h"
#include "support/temporary_folder.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Three N, 5 mm apart, in the manner of the fCal phantom.
WirePhantom ThreeNs() {
  WirePhantom phantom;
  const double oblique_mm[3][2] = {{40, 25}, {25, 45}, {45, 25}};
  for (int n = 0; n < 3; ++n) {
    const double z = 10.0 - 5.0 * n, last = n == 0 ? 45.0 : 50.0;
    const std::string name = std::to_string(n);
    phantom.patterns.push_back(
        {Wire{"a" + name, {20, 0, z}, {20, 40, z}},
         Wire{"b" + name, {oblique_mm[n][0], 0, z}, {oblique_mm[n][1], 40, z}},
         Wire{"c" + name, {last, 0, z}, {last, 40, z}}});
  }
  return phantom;
}

/// A calibration to find, with pixels that are not square.
struct ProbeTruth {
  Isometry3d probe_from_image = Eigen::Translation3d(11.0, 50.0, -4.0) *
                                AngleAxisd(1.9, Vector3d(0.3, -0.5, 0.8).normalized());
  Vector2d mm_per_px = {0.08, 0.065};
  Vector2d size_px = {640.0, 480.0};

  Vector3d At(const Vector2d& point_px) const {
    const Vector2d mm = mm_per_px.cwiseProduct(point_px);
    return probe_from_image * Vector3d(mm.x(), mm.y(), 0.0);
  }
};

struct ProbeNoise {
  double px = 0.0;          ///< Of each point.
  double tracker_mm = 0.0;  ///< Of each pose.
  double tracker_rad = 0.0;
  bool laplace = false;  ///< Heavier tails than normal ones.
};

double DrawError(RandomStream& random, bool laplace) {
  if (!laplace) return random.Normal();
  const double u = random.Uniform(-0.5, 0.5);
  return (u < 0 ? 1.0 : -1.0) * std::log(1.0 - 2.0 * std::abs(u)) / std::numbers::sqrt2;
}

Vector3d DrawVector3(RandomStream& random) {
  return {random.Normal(), random.Normal(), random.Normal()};
}

/// Images across the wires, from poses that vary by millimetres and some ten degrees.
std::vector<WireImage> WireImagesFrom(std::size_t count, const ProbeNoise& noise,
                                      std::uint64_t seed, const ProbeTruth& truth = {},
                                      double variation = 1.0) {
  RandomStream random(seed, "probe");
  const WirePhantom phantom = ThreeNs();
  Eigen::Matrix3d axes;  // Of the image in the phantom: columns along -x, rows along -z.
  axes << -1, 0, 0, 0, 0, 1, 0, -1, 0;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  std::vector<WireImage> images;
  while (images.size() < count) {
    const Vector3d turn = variation * 0.12 * DrawVector3(random);
    Isometry3d phantom_from_image = Isometry3d::Identity();
    phantom_from_image.linear() =
        axes * AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    phantom_from_image.translation() = Vector3d(57.0 + variation * 2.0 * random.Normal(),
                                                20.0 + variation * random.Uniform(-12.0, 12.0),
                                                22.0 + variation * 3.0 * random.Normal());
    WireImage image;
    image.probe_from_phantom = truth.probe_from_image * phantom_from_image.inverse();
    for (std::size_t w = 0; w < phantom.num_wires(); ++w) {
      const Wire& wire = phantom.WireAt(w);
      const Vector3d front = phantom_from_image.inverse() * wire.front_mm;
      const Vector3d back = phantom_from_image.inverse() * wire.back_mm;
      const Vector3d cut = front + front.z() / (front.z() - back.z()) * (back - front);
      const Vector2d point(cut.x() / truth.mm_per_px.x(), cut.y() / truth.mm_per_px.y());
      image.points_px.emplace_back(point + noise.px * Vector2d(DrawError(random, noise.laplace),
                                                               DrawError(random, noise.laplace)));
    }
    const Vector3d wrong_rad = noise.tracker_rad * DrawVector3(random);
    const Isometry3d error =
        Eigen::Translation3d(noise.tracker_mm * DrawVector3(random)) *
        AngleAxisd(wrong_rad.norm() + 1e-300, (wrong_rad + Vector3d(1e-300, 0, 0)).normalized());
    image.probe_from_phantom = image.probe_from_phantom * error;
    images.push_back(image);
  }
  return images;
}

ProbeCalibrationSettings ImageSettings(const ProbeTruth& truth = {}) {
  return {.image_px = truth.size_px};
}

double CornerErrorMm(const ProbeCalibration& result, const Vector2d& corner_px,
                     const ProbeTruth& truth = {}) {
  const Vector3d place =
      (result.ImageToProbe() * Eigen::Vector4d(corner_px.x(), corner_px.y(), 0, 1)).head<3>();
  return (place - truth.At(corner_px)).norm();
}

double WorstCornerMm(const ProbeCalibration& result, const ProbeTruth& truth = {}) {
  double worst = 0.0;
  for (const PixelError& corner : result.corners) {
    worst = std::max(worst, CornerErrorMm(result, corner.point_px, truth));
  }
  return worst;
}

TEST(CalibrateByWires, IsExactWithoutNoise) {
  for (const std::size_t count : {10U, 40U}) {
    const ProbeCalibration result =
        CalibrateByWires(ThreeNs(), WireImagesFrom(count, {}, 1), ImageSettings());
    EXPECT_LT(WorstCornerMm(result), 1e-6) << count;
    EXPECT_LT((result.mm_per_px - ProbeTruth().mm_per_px).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT(result.in_plane_rms_mm, 1e-6);
    EXPECT_LT(result.out_of_plane_rms_mm, 1e-6);
    EXPECT_EQ(std::ranges::count(result.residuals, false, &PointResidual::used), 0);
    EXPECT_EQ(result.num_images, count);
    ASSERT_EQ(result.corners.size(), 4U);
    EXPECT_EQ(result.corners[3].point_px, ProbeTruth().size_px);
  }
}

TEST(CalibrateByWires, ErrorFallsWithTheNoise) {
  std::vector<double> rms_mm;
  for (const double px : {0.25, 1.0, 4.0}) {
    double squares = 0.0;
    constexpr int kTrials = 6;
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto images = WireImagesFrom(30, {.px = px}, static_cast<std::uint64_t>(trial));
      const double error_mm = WorstCornerMm(CalibrateByWires(ThreeNs(), images, ImageSettings()));
      squares += error_mm * error_mm / kTrials;
    }
    rms_mm.push_back(std::sqrt(squares));
  }
  EXPECT_NEAR(rms_mm[1] / rms_mm[0], 4.0, 0.4);  // First order in the noise.
  EXPECT_NEAR(rms_mm[2] / rms_mm[1], 4.0, 0.6);
  EXPECT_LT(rms_mm[0], 0.2);
}

/// Of 100 simulated calibrations, those whose bound at a corner and interval of a scale hold.
struct HeldOf100 {
  int corner = 0;
  int scale = 0;
};

HeldOf100 HeldByWires(std::size_t num_images, const ProbeNoise& noise) {
  HeldOf100 held;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto result =
        CalibrateByWires(ThreeNs(), WireImagesFrom(num_images, noise, seed), ImageSettings());
    const PixelError& corner = result.corners[3];
    if (CornerErrorMm(result, corner.point_px) <= corner.bound_mm) ++held.corner;
    const double scale_error = std::abs(result.mm_per_px.y() - ProbeTruth().mm_per_px.y());
    if (scale_error <= result.mm_per_px_half_width.y()) ++held.scale;
  }
  return held;
}

TEST(CalibrateByWires, BoundsHoldAsOftenAsStatedUnderNoiseOfPixelsAndTracker) {
  const ProbeNoise noises[] = {
      {.px = 1.0, .tracker_mm = 0.3, .tracker_rad = 0.004},
      {.px = 2.0, .tracker_mm = 0.1, .tracker_rad = 0.002, .laplace = true}};
  for (const ProbeNoise& noise : noises) {
    const HeldOf100 held = HeldByWires(20, noise);
    EXPECT_GE(held.corner, 88) << noise.px << " " << noise.tracker_mm;
    EXPECT_LE(held.corner, 99) << noise.px << " " << noise.tracker_mm;
    EXPECT_GE(held.scale, 88) << noise.px << " " << noise.tracker_mm;
    EXPECT_LE(held.scale, 99) << noise.px << " " << noise.tracker_mm;
  }
}

TEST(CalibrateByWires, NamesAndExcludesOutliers) {
  auto images = WireImagesFrom(30, {.px = 0.5}, 5);
  *images[3].points_px[4] += Vector2d(30.0, -10.0);
  *images[7].points_px[0] += Vector2d(0.0, 25.0);
  *images[20].points_px[8] -= Vector2d(60.0, 0.0);
  std::swap(images[11].points_px[1], images[11].points_px[2]);
  const ProbeCalibration result = CalibrateByWires(ThreeNs(), images, ImageSettings());
  std::vector<std::pair<std::size_t, std::size_t>> excluded;
  for (const PointResidual& point : result.residuals) {
    if (!point.used) excluded.emplace_back(point.image, point.wire);
  }
  EXPECT_THAT(excluded,
              testing::ElementsAre(testing::Pair(3, 4), testing::Pair(7, 0), testing::Pair(11, 1),
                                   testing::Pair(11, 2), testing::Pair(20, 8)));
  EXPECT_LT(WorstCornerMm(result), 0.25);
}

TEST(CalibrateByWires, AnOutlierDoesNotEnlargeTheImage) {
  auto images = WireImagesFrom(20, {.px = 0.2}, 9);
  images[5].points_px[4]->x() = 7000.0;
  const ProbeCalibration result = CalibrateByWires(ThreeNs(), images, {});
  EXPECT_LT(result.corners[3].point_px.x(), 800.0);
}

TEST(CalibrateByWires, ExcludesImagesWhosePoseIsWrong) {
  auto images = WireImagesFrom(30, {.px = 0.5}, 6);
  for (const std::size_t i : {2U, 14U, 21U}) {
    images[i].probe_from_phantom.translation() += Vector3d(8.0, -6.0, 5.0);
  }
  const ProbeCalibration result = CalibrateByWires(ThreeNs(), images, ImageSettings());
  EXPECT_LT(WorstCornerMm(result), 0.25);
}

TEST(CalibrateByWires, UsesWiresOfAnNThatIsNotWhole) {
  auto images = WireImagesFrom(20, {}, 7);
  for (std::size_t i = 0; i < images.size(); ++i) images[i].points_px[i % 9].reset();
  const ProbeCalibration result = CalibrateByWires(ThreeNs(), images, ImageSettings());
  EXPECT_LT(WorstCornerMm(result), 1e-6);
  EXPECT_EQ(result.residuals.size(), 20U * 8U);
  EXPECT_EQ(result.middle_wires.size(), 20U * 2U);
}

TEST(CalibrateByWires, ThirdAxisIsAsLongAsPlusMakesIt) {
  const Eigen::Matrix4d matrix =
      CalibrateByWires(ThreeNs(), WireImagesFrom(12, {}, 2), ImageSettings()).ImageToProbe();
  EXPECT_NEAR(matrix.col(0).norm(), 0.08, 1e-9);
  EXPECT_NEAR(matrix.col(1).norm(), 0.065, 1e-9);
  EXPECT_NEAR(matrix.col(2).norm(), 0.0725, 1e-9);
  EXPECT_NEAR(matrix.col(0).dot(matrix.col(1)), 0.0, 1e-12);
  const Eigen::Matrix3d linear = matrix.topLeftCorner(3, 3);
  EXPECT_GT(linear.determinant(), 0.0);
}

TEST(CalibrateByWires, MatrixIsReadBackFromAPlusConfiguration) {
  const testing_support::TemporaryFolder folder;
  const Eigen::Matrix4d matrix =
      CalibrateByWires(ThreeNs(), WireImagesFrom(12, {.px = 0.5}, 2), ImageSettings())
          .ImageToProbe();
  const auto path = folder.path() / "IsReadBackFromPlus.xml";
  session::WritePlusCalibration(path, "Image", "Probe", matrix, 0.25);
  EXPECT_EQ(session::ReadPlusCalibrations(path).at("ImageToProbe"), matrix);  // The same bits.
}

TEST(CalibrateByWires, SaysWhatToAdd) {
  EXPECT_THAT(
      [] { CalibrateByWires(ThreeNs(), WireImagesFrom(9, {.px = 0.5}, 1), ImageSettings()); },
      ThrowsMessage<NoAnswerError>(
          HasSubstr("9 images show the three wires of an N; at least 10 are needed: add")));
  // One N, always at the same depth: its middle wire runs along one row.
  WirePhantom one = ThreeNs();
  one.patterns.resize(1);
  auto images = WireImagesFrom(30, {}, 1, {}, 0.0);
  RandomStream random(1, "along the row");
  for (WireImage& image : images) {
    image.points_px.resize(3);
    const Vector3d along(0.0, random.Uniform(-10.0, 10.0), 0.0);
    image.probe_from_phantom = image.probe_from_phantom * Eigen::Translation3d(-along);
    const double share = (20.0 + along.y()) / 40.0;  // Of the oblique wire: 40 to 25 mm.
    image.points_px[1]->x() = (57.0 - (40.0 - 15.0 * share)) / 0.08;
  }
  EXPECT_THAT([&] { CalibrateByWires(one, images, ImageSettings()); },
              ThrowsMessage<NoAnswerError>(
                  testing::AllOf(HasSubstr("the points lie on a line in the image"),
                                 HasSubstr("add images in which the wires lie at other depths"))));
}

TEST(CalibrateByWires, RefusesWiresThatAreNamedWrongly) {
  auto images = WireImagesFrom(30, {.px = 0.5}, 8);
  for (WireImage& image : images) {
    for (std::size_t n = 0; n < 3; ++n) {  // From right to left in place of left to right.
      std::swap(image.points_px[3 * n], image.points_px[3 * n + 2]);
    }
  }
  EXPECT_THAT([&] { CalibrateByWires(ThreeNs(), images, ImageSettings()); },
              ThrowsMessage<NoAnswerError>(HasSubstr("check the names of the wires")));
}

TEST(CalibrateByWires, RefusesAnotherUnit) {
  auto images = WireImagesFrom(30, {}, 8);
  for (WireImage& image : images) {
    for (auto& point : image.points_px) *point /= 1000.0;
  }
  WirePhantom phantom = ThreeNs();
  EXPECT_THROW(CalibrateByWires(phantom, images, {}), std::runtime_error);
}

/// Points of a stylus over the whole image.
std::vector<SeenPoint> StylusPoints(std::size_t count, double px, double mm, std::uint64_t seed) {
  const ProbeTruth truth;
  RandomStream random(seed, "stylus");
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d point(random.Uniform(0.0, truth.size_px.x()),
                         random.Uniform(0.0, truth.size_px.y()));
    // Thick slice: the tip is seen beside the plane.
    const Vector3d beside = truth.probe_from_image.linear().col(2) * 2.0 * mm * random.Normal();
    points.push_back({point + px * Vector2d(random.Normal(), random.Normal()),
                      truth.At(point) + beside + mm * DrawVector3(random)});
  }
  return points;
}

TEST(CalibrateByPoints, IsExactWithoutNoise) {
  const ProbeCalibration result = CalibrateByPoints(StylusPoints(12, 0.0, 0.0, 1), ImageSettings());
  EXPECT_LT(WorstCornerMm(result), 1e-6);
  EXPECT_LT(result.out_of_plane_rms_mm, 1e-6);
  EXPECT_EQ(result.middle_wires.size(), 0U);
}

TEST(CalibrateByPoints, BoundsHoldAsOftenAsStated) {
  HeldOf100 held;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto result = CalibrateByPoints(StylusPoints(25, 1.0, 0.3, seed), ImageSettings());
    const PixelError& corner = result.corners[1];
    if (CornerErrorMm(result, corner.point_px) <= corner.bound_mm) ++held.corner;
    if (std::abs(result.mm_per_px.x() - 0.08) <= result.mm_per_px_half_width.x()) ++held.scale;
  }
  EXPECT_GE(held.corner, 88);
  EXPECT_LE(held.corner, 99);
  EXPECT_GE(held.scale, 88);
  EXPECT_LE(held.scale, 99);
}

TEST(CalibrateByPoints, ExcludesOutliersAndHardlyAnythingElse) {
  std::ptrdiff_t num_excluded = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto points = StylusPoints(30, 0.5, 0.1, seed);
    points[4].probe_mm += Vector3d(9.0, 0.0, 0.0);
    points[17].point_px += Vector2d(0.0, 120.0);
    const ProbeCalibration result = CalibrateByPoints(points, ImageSettings());
    EXPECT_FALSE(result.residuals[4].used) << seed;
    EXPECT_FALSE(result.residuals[17].used) << seed;
    num_excluded += std::ranges::count(result.residuals, false, &PointResidual::used);
    EXPECT_LT(WorstCornerMm(result), 0.5) << seed;
  }
  EXPECT_LE(num_excluded, 21);  // Of 280 good points one at most.
}

TEST(CalibrateByPoints, SaysWhatToAdd) {
  EXPECT_THAT(
      [] { CalibrateByPoints(StylusPoints(9, 0.0, 0.0, 1), ImageSettings()); },
      ThrowsMessage<NoAnswerError>(HasSubstr("there are 9 points of the stylus; at least")));
  auto points = StylusPoints(30, 0.0, 0.0, 1);
  for (SeenPoint& point : points) {
    point.point_px.y() = 240.0 + 0.1 * point.point_px.x();
    point.probe_mm = ProbeTruth().At(point.point_px);
  }
  EXPECT_THAT([&] { CalibrateByPoints(points, ImageSettings()); },
              ThrowsMessage<NoAnswerError>(HasSubstr("add points at other depths and sides")));
  // A narrow strip: barely off a line, far from the other corners.
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].point_px.y() += i % 2 == 0 ? 4.0 : -4.0;
    points[i].probe_mm = ProbeTruth().At(points[i].point_px);
  }
  EXPECT_THAT([&] { CalibrateByPoints(points, ImageSettings()); },
              ThrowsMessage<NoAnswerError>(HasSubstr("do not determine the calibration")));
}

TEST(CalibrateByPoints, RefusesMetres) {
  auto points = StylusPoints(20, 0.0, 0.0, 1);
  for (SeenPoint& point : points) point.probe_mm /= 1000.0;
  EXPECT_THAT([&] { CalibrateByPoints(points, ImageSettings()); },
              ThrowsMessage<InputError>(HasSubstr("are poses and points in mm")));
}

}  // namespace
}  // namespace acus::registration
