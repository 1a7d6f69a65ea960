#include "acus/imaging/ultrasound/columns/alamilla.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"

namespace acus::ultrasound {
namespace {

constexpr volume::Label kFat = 2;
constexpr volume::Label kMuscle = 3;
constexpr volume::Label kBone = 5;

/// 0.5 mm per pixel, no black sides.
acoustics::Probe TestProbe() {
  return {.name = "test",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 5,
          .width_mm = 64,
          .depth_mm = 63.5,
          .image_width_px = 128,
          .image_height_px = 128,
          .slice_thickness_mm = 3,
          .dynamic_range_db = 60};
}

template <typename Label>
volume::LabelMap Scene(const Label& label_at) {
  volume::Geometry geometry;
  geometry.size = {192, 160, 40};
  geometry.spacing_mm.setConstant(0.5);
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 160; ++j) {
      for (int i = 0; i < 192; ++i) {
        labels.At(i, j, k) = label_at(0.5 * i, 0.5 * j, 0.5 * k);
      }
    }
  }
  labels.names = {{0, "outside"}, {kFat, "fat"}, {kMuscle, "muscle"}, {kBone, "bone"}};
  return labels;
}

/// No stage at all: each tissue in its grey.
AlamillaOptions Flat() {
  AlamillaOptions options;
  options.tissues = {{.tissue = "fat", .grey = 0.3, .contrast = 0.8},
                     {.tissue = "muscle", .grey = 0.5, .contrast = 0.8},
                     {.tissue = "bone", .grey = 0.8, .blocks = true}};
  options.reflection = options.shadow = options.absorption = options.speckle = false;
  options.surface_mm = 1.0;
  options.coupling_gap_mm = 5.0;
  return options;
}

/// The face along +x at y = 4 mm, beams along +y.
Eigen::Isometry3d Pose() {
  return Eigen::Isometry3d(Eigen::Translation3d(48, 4, 10));
}

image::GrayImage Image(const volume::LabelMap& labels, const AlamillaOptions& options,
                       const Eigen::Isometry3d& pose = Pose(),
                       const std::optional<image::NeedleInImage>& needle = std::nullopt) {
  image::GrayImage image;
  AlamillaRenderer(labels, TestProbe(), options).Render(pose, needle, image);
  return image;
}

volume::Label TwoLayers(double, double y, double) {
  return y < 30.0 ? kFat : kMuscle;
}

TEST(Alamilla, EachTissueHasItsGreyAndLosesItByAbsorption) {
  const auto labels = Scene(TwoLayers);
  AlamillaOptions options = Flat();
  const image::GrayImage flat = Image(labels, options);
  EXPECT_NEAR(flat.At(64, 40), 255 * 0.3, 0.6);
  EXPECT_NEAR(flat.At(64, 100), 255 * 0.5, 0.6);
  options.absorption = true;
  options.tissues[0].absorption_per_cm = 0.2;
  options.tissues[1].absorption_per_cm = 0.5;
  const image::GrayImage image = Image(labels, options);
  EXPECT_NEAR(image.At(64, 40), 255 * 0.3 * std::exp(-0.2 * 2.0), 0.6);               // 20 mm deep
  EXPECT_NEAR(image.At(64, 100), 255 * 0.5 * std::exp(-0.2 * 2.6 - 0.5 * 2.4), 0.8);  // 50 mm
}

/// All tissue has moved by this since the CT.
struct MovedBy : slicing::RestMap {
  explicit MovedBy(const Eigen::Vector3d& moved) : moved_mm(moved) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d&) const noexcept override {
    return place_in_ct_mm - moved_mm;
  }
  double SpacingMm() const noexcept override { return 2.0; }
  Eigen::Vector3d moved_mm;
};

// Section V.B: the displacement is applied to the pixels of the finished image. Absorption is then
// that of the depth at rest; in a displaced scene it is that of the depth now.
TEST(Alamilla, AsPrintedThePixelsOfTheFinishedImageAreDisplaced) {
  const auto labels = Scene(TwoLayers);
  AlamillaOptions options = Flat();
  options.absorption = true;
  options.tissues[0].absorption_per_cm = 0.2;
  options.tissues[1].absorption_per_cm = 0.5;
  const image::GrayImage at_rest = Image(labels, options);
  const MovedBy deeper(Eigen::Vector3d(0.0, 5.0, 0.0));  // 10 pixels.
  const image::NeedleInImage needle{.tip_in_ct_mm = {48, 40, 10},
                                    .axis_in_ct = Eigen::Vector3d::UnitX(),
                                    .length_mm = 60,
                                    .radius_mm = 0.6};
  const auto moved = [&](bool pixels, const std::optional<image::NeedleInImage>& tool) {
    options.displaces_pixels = pixels;
    image::GrayImage image;
    AlamillaRenderer(labels, TestProbe(), options).Render(Pose(), tool, image, 1, &deeper);
    return image;
  };
  const image::GrayImage pixels = moved(true, std::nullopt);
  for (int row = 11; row < 128; ++row) ASSERT_EQ(pixels.At(64, row), at_rest.At(64, row - 10));
  EXPECT_EQ(pixels.At(64, 5), 0);  // Its rest is above the image.
  const image::GrayImage scene = moved(false, std::nullopt);
  EXPECT_NEAR(scene.At(64, 40), 255 * 0.3 * std::exp(-0.2 * 1.9), 0.8);  // Air in its first 1 mm.
  EXPECT_NEAR(pixels.At(64, 40), 255 * 0.3 * std::exp(-0.2 * 1.5), 0.6);
  // The needle lies where it is: along row 72, to column 64.
  const image::GrayImage with_needle = moved(true, needle);
  EXPECT_GT(with_needle.At(60, 72), pixels.At(60, 72) + 40);
  EXPECT_EQ(with_needle.At(60, 62), pixels.At(60, 62));
  EXPECT_EQ(with_needle.At(68, 72), pixels.At(68, 72));
}

TEST(Alamilla, GainBrightensByItsShareOfTheDynamicRange) {
  const volume::LabelMap labels = Scene(TwoLayers);
  AlamillaOptions options = Flat();
  options.gain_of_table_db = 3.0;
  acoustics::Probe probe = TestProbe();
  std::vector<int> greys;
  for (const double gain_db : {3.0, 9.0}) {
    probe.gain_db = gain_db;
    image::GrayImage image;
    AlamillaRenderer(labels, probe, options).Render(Pose(), std::nullopt, image);
    greys.push_back(image.At(image.width / 2, 20));
  }
  EXPECT_NEAR(greys[1] - greys[0], 255.0 * 6.0 / probe.dynamic_range_db, 1.01);
}

/// A muscle along x with the shipped examples; where its fibres run is told by its surface.
AlamillaOptions WithExamples() {
  AlamillaOptions options = Flat();
  const auto textures = std::filesystem::path(ACUS_SOURCE_DIR) / "configs/textures";
  options.tissues[1].grey = 0.4;
  options.tissues[1].texture = TissueTexture::kThickFibres;
  options.tissues[1].example = {textures / "muscle_along.png", textures / "muscle_across.png",
                                0.15};
  options.speckle = options.fibres = true;
  return options;
}

volume::LabelMap MuscleAlongX() {
  return Scene([](double, double y, double z) {
    return (y - 40) * (y - 40) / 900 + (z - 10) * (z - 10) / 81 < 1.0 ? kMuscle : kFat;
  });
}

TEST(Alamilla, ExampleTexturesKeepTheGreyOfTheTable) {
  const volume::LabelMap labels = MuscleAlongX();
  const AlamillaOptions options = WithExamples();
  AlamillaRenderer renderer(labels, TestProbe(), options);
  const Eigen::Isometry3d along = Pose();
  Eigen::Isometry3d across = along;
  across.linear() << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  for (const Eigen::Isometry3d& pose : {along, across}) {
    image::GrayImage image, threads;
    renderer.Render(pose, std::nullopt, image);
    renderer.Render(pose, std::nullopt, threads, 4);
    EXPECT_EQ(image.pixels, threads.pixels);
    // In the muscle, 8 mm to each side of the middle of both planes.
    double sum = 0.0, squares = 0.0, aside = 0.0, down = 0.0;
    int count = 0;
    for (int r = 30; r < 110; ++r) {
      for (int c = 50; c < 78; ++c, ++count) {
        const double grey = image.At(c, r) - 0.4 * 255;
        sum += grey;
        squares += grey * grey;
        aside += grey * (image.At(c + 2, r) - 0.4 * 255);
        down += grey * (image.At(c, r + 2) - 0.4 * 255);
      }
    }
    EXPECT_NEAR(sum / count, 0.0, 0.08 * 0.4 * 255);
    EXPECT_GT(std::sqrt(squares / count), 0.3 * 0.4 * 255);
    if (pose.isApprox(along)) {
      EXPECT_GT(aside / squares, 0.7) << "streaks";
      EXPECT_LT(down / squares, 0.4);
    } else {
      EXPECT_LT(aside / squares, 0.4) << "dots";
    }
  }
}

TEST(Alamilla, ExampleImagesAreReadFromTheTable) {
  const auto preset = ReadAlamillaOptions(std::filesystem::path(ACUS_SOURCE_DIR) /
                                          "configs/acoustics/alamilla_2021_examples.json");
  EXPECT_EQ(preset.ExampleImages().size(), 3U);
  AlamillaOptions options = WithExamples();
  options.tissues[1].example->along = "nowhere.png";
  EXPECT_THROW(AlamillaRenderer(MuscleAlongX(), TestProbe(), options), InputError);
}

TEST(Alamilla, BoneShadowsBehindItsSurface) {
  const auto labels = Scene([](double x, double y, double) {
    if (x < 48.0 && y >= 30.0 && y < 40.0) return kBone;
    return kFat;
  });
  AlamillaOptions options = Flat();
  options.shadow = true;
  options.shadow_share = 0.1;
  const image::GrayImage image = Image(labels, options);
  EXPECT_NEAR(image.At(20, 53), 255 * 0.8, 0.6) << "the surface itself";
  EXPECT_NEAR(image.At(20, 60), 255 * 0.08, 0.6) << "within the bone";
  EXPECT_NEAR(image.At(20, 110), 255 * 0.03, 0.6) << "behind it";
  EXPECT_NEAR(image.At(110, 110), 255 * 0.3, 0.6) << "beside it";
}

/// Brightest pixel of the surface between two layers whose normal is turned by an angle.
double ReflectionAt(double angle_deg, const AlamillaOptions& options) {
  const double tangent = std::tan(angle_deg * std::numbers::pi / 180.0);
  const auto labels = Scene([tangent](double x, double y, double) {
    return y < 34.0 + tangent * (x - 48.0) ? kFat : kMuscle;
  });
  AlamillaOptions none = options;
  none.reflection = false;
  const image::GrayImage lit = Image(labels, options);
  const image::GrayImage dark = Image(labels, none);
  double sum = 0.0;  // Over columns: steps of the voxels differ.
  for (int c = 54; c < 74; ++c) {
    int most = 0;
    for (int r = 0; r < 128; ++r) most = std::max(most, lit.At(c, r) - dark.At(c, r));
    sum += most;
  }
  return sum / 20.0;
}

TEST(Alamilla, ReflectionsFallWithTheAngleOfTheDepthMap) {
  AlamillaOptions options = Flat();
  options.reflection = true;
  options.tissues[0].reflection = 0.1;
  options.tissues[1].reflection = 0.4;
  EXPECT_NEAR(ReflectionAt(0.0, options), 255 * 0.4, 1.0) << "the larger one counts";
  EXPECT_NEAR(ReflectionAt(40.0, options), 255 * 0.4, 1.0) << "the angle is off";
  options.angle_exponent = 2;
  for (const double deg : {0.0, 20.0, 40.0, 55.0}) {
    const double cosine = std::cos(deg * std::numbers::pi / 180.0);
    EXPECT_NEAR(ReflectionAt(deg, options), 255 * 0.4 * cosine * cosine, 6.0) << deg;
  }
}

/// Mean of products of deviations `across` columns and `down` rows apart, over that at 0.
double Correlation(const image::GrayImage& image, int across, int down) {
  double mean = 0.0;
  for (const std::uint8_t p : image.pixels) mean += p;
  mean /= static_cast<double>(image.pixels.size());
  double square = 0.0;
  double product = 0.0;
  for (int r = 10; r < 110; ++r) {
    for (int c = 10; c < 110; ++c) {
      const double value = image.At(c, r) - mean;
      square += value * value;
      product += value * (image.At(c + across, r + down) - mean);
    }
  }
  return product / square;
}

/// A bar of muscle along x: 30 mm deep, 20 mm thick.
volume::LabelMap Bar() {
  return Scene([](double, double y, double z) {
    return y > 5.0 && y < 75.0 && z > 2.0 && z < 18.0 ? kMuscle : kFat;
  });
}

AlamillaOptions Textured(TissueTexture texture) {
  AlamillaOptions options = Flat();
  options.speckle = options.fibres = true;
  options.tissues[1].grain_mm = 1.0;
  options.tissues[1].texture = texture;
  options.thick_fibre_ratio = 8.0;
  options.thin_fibre_mm = 6.0;
  return options;
}

TEST(Alamilla, SpeckleIsRoundAndLivesInTheTissue) {
  const auto labels = Bar();
  const AlamillaOptions options = Textured(TissueTexture::kSpeckle);
  const image::GrayImage image = Image(labels, options);
  EXPECT_NEAR(Correlation(image, 1, 0), Correlation(image, 0, 1), 0.1);
  EXPECT_LT(std::abs(Correlation(image, 6, 0)), 0.15);
  const image::GrayImage beside =
      Image(labels, options, Pose() * Eigen::Translation3d(2.0, 1.0, 0.0));
  for (int r = 20; r < 100; ++r) {
    for (int c = 10; c < 110; ++c) EXPECT_NEAR(beside.At(c, r), image.At(c + 4, r + 2), 1);
  }
}

// Longitudinal texture where the plane holds the fibres, lateral texture where it cuts them.
TEST(Alamilla, FibresAreStreaksAlongAndDotsAcross) {
  const auto labels = Bar();
  const Eigen::Isometry3d along = Pose();
  Eigen::Isometry3d across = Pose();
  across.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()));
  for (const TissueTexture texture : {TissueTexture::kThickFibres, TissueTexture::kThinFibres}) {
    AlamillaOptions options = Textured(texture);
    const image::GrayImage streaks = Image(labels, options, along);
    EXPECT_GT(Correlation(streaks, 4, 0), 0.45) << "along the fibres";
    EXPECT_LT(Correlation(streaks, 0, 4), 0.25) << "across them";
    // Only the muscle's 16 mm are in the image that cuts the bar.
    image::GrayImage dots = Image(labels, options, across);
    double gap = 0.0;
    for (int r = 20; r < 100; ++r) {
      for (int c = 52; c < 72; ++c) {
        gap += std::abs(dots.At(c + 2, r) - dots.At(c, r)) -
               std::abs(dots.At(c, r + 2) - dots.At(c, r));
      }
    }
    EXPECT_LT(std::abs(gap) / (80 * 20), 6.0) << "as rough down as across";
    options.fibres = false;
    EXPECT_NEAR(Correlation(Image(labels, options), 4, 0), 0.0, 0.2) << "switched off";
  }
}

TEST(Alamilla, TheNeedleIsALineWithAShadow) {
  const auto labels = Scene(TwoLayers);
  AlamillaOptions options = Flat();
  options.reflection = options.shadow = true;
  options.needle_share = 0.4;
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = {58.0, 24.0, 10.0};
  needle.axis_in_ct = Eigen::Vector3d::UnitX();
  needle.length_mm = 20.0;
  needle.radius_mm = 0.6;
  const image::GrayImage image = Image(labels, options, Pose(), needle);
  const image::GrayImage bare = Image(labels, options);
  int brightest = 0;
  for (int r = 37; r < 43; ++r) brightest = std::max<int>(brightest, image.At(64, r));
  EXPECT_EQ(brightest, 255);
  EXPECT_NEAR(image.At(64, 80), 0.4 * bare.At(64, 80), 0.6);
  EXPECT_EQ(image.At(110, 80), bare.At(110, 80));
}

TEST(Alamilla, AWideGapOfAirGivesNoImage) {
  const auto labels =
      Scene([](double, double y, double) { return y < 8.0 ? volume::Label{0} : kFat; });
  AlamillaOptions options = Flat();
  EXPECT_NEAR(Image(labels, options).At(64, 60), 255 * 0.3, 0.6);
  options.coupling_gap_mm = 3.0;
  EXPECT_EQ(Image(labels, options).At(64, 60), 0);
}

TEST(Alamilla, RefusesATissueWithoutRowAndWrongOptions) {
  const auto labels = Scene(TwoLayers);
  const auto refused = [&labels](auto&& change) {
    AlamillaOptions options = Flat();
    change(options);
    EXPECT_THROW(AlamillaRenderer(labels, TestProbe(), options), InputError);
  };
  refused([](AlamillaOptions& o) { o.tissues.erase(o.tissues.begin()); });
  refused([](AlamillaOptions& o) { o.surface_mm = 0.0; });
  refused([](AlamillaOptions& o) { o.thick_fibre_ratio = 0.5; });
  refused([](AlamillaOptions& o) { o.tissues[0].grain_mm = 0.0; });
  const auto preset = ReadAlamillaOptions(std::filesystem::path(ACUS_SOURCE_DIR) /
                                          "configs/acoustics/alamilla_2021.json");
  EXPECT_EQ(preset.tissues.size(), volume::StandardLabels().size() - 1);  // All but outside.
}

}  // namespace
}  // namespace acus::ultrasound
