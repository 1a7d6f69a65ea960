// Speckle against what theory says of many scatterers seen through a point spread: Rayleigh's
// envelope, correlation, contrast, and that it moves with the tissue.
#include <gtest/gtest.h>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Bare;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::Scattering;
using testing_support::TableOf;
using testing_support::TargetProbe;

BeamOptions SpeckleOnly() {
  BeamOptions options = Bare();
  options.speckle = options.point_spread = true;
  return options;
}

volume::LabelMap UltrasoundSpeckleHomogeneous() {
  return LabelledBlock({60, 90, 200}, 0.5, {{1, "liver"}},
                       [](double, double, double) { return volume::Label{1}; });
}

/// Planes far enough apart to be independent: more than the slice is thick.
constexpr double kApartMm = 3.0;

// Pulse: 2 ln 2 / pi lambda / bandwidth. Beam in the focus, there and back: sinc^2 falls to half at
// 0.886 lambda F.
constexpr double kLambdaMm = 1540e-3 / 5.0;
const double kPulseMm = 2.0 * std::numbers::ln2 / std::numbers::pi * kLambdaMm / 0.6;
constexpr double kBeamMm = 0.886 * kLambdaMm * 2.0;

TEST(BeamSpeckle, EnvelopeIsRayleighOverTenThousandCells) {
  const auto table = TableOf({{"liver", Scattering()}});
  const auto labels = UltrasoundSpeckleHomogeneous();
  const acoustics::Probe probe = TargetProbe();
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, SpeckleOnly());
  double sum = 0.0;
  double square = 0.0;
  double count = 0.0;
  double cells = 0.0;
  image::GrayImage image;
  for (double z_mm = 2.0; z_mm < 98.0; z_mm += kApartMm) {
    renderer.Render(FaceAt(15.0, 0.5, z_mm), std::nullopt, image, 2);
    const slicing::BeamImage& envelope = renderer.envelope();
    for (int k = 50; k < 350; ++k) {
      for (int l = 10; l < envelope.lines() - 10; ++l) {
        const double value = envelope.row(k)[l];
        sum += value;
        square += value * value;
        count += 1.0;
      }
    }
    cells += 30.0 / kPulseMm * (109 * 0.2) / (1.5 * kBeamMm);  // Beams are wider off the focus.
  }
  ASSERT_GT(cells, 1e4);
  const double mean = sum / count;
  EXPECT_NEAR(mean / std::sqrt(square / count - mean * mean), 1.91, 0.03);
}

/// Lag at which the covariance of the intensity falls to half, in samples of that direction.
struct Widths {
  double along = 0.0;
  double across = 0.0;
};

double HalfWidth(const std::vector<double>& covariance) {
  for (std::size_t n = 1; n < covariance.size(); ++n) {
    const double before = covariance[n - 1] / covariance[0];
    const double here = covariance[n] / covariance[0];
    if (here < 0.5) return static_cast<double>(n) - (0.5 - here) / (before - here);
  }
  return 1e9;
}

Widths CorrelationAtTheFocus(BeamRenderer& renderer) {
  constexpr int kLags = 16;
  std::vector<double> along(kLags, 0.0);
  std::vector<double> across(kLags, 0.0);
  double mean = 0.0;
  double count = 0.0;
  const int focus = static_cast<int>(20.0 / renderer.grid().step_mm);
  // The beam is half as wide again a few millimetres off the focus.
  const int reach = static_cast<int>(0.5 / renderer.grid().step_mm);
  for (int pass = 0; pass < 2; ++pass) {
    for (int view = 0; view < 5 * 32; ++view) {
      const double z_mm = 2.0 + view % 32 * kApartMm;
      image::GrayImage image;
      renderer.Render(FaceAt(15.0, 0.5 + 4.0 * (view / 32), z_mm), std::nullopt, image, 2);
      const slicing::BeamImage& envelope = renderer.envelope();
      const auto intensity = [&](int k, int l) {
        return double{envelope.row(k)[l]} * envelope.row(k)[l];
      };
      for (int k = focus - reach; k < focus + reach; ++k) {
        for (int l = 10; l < envelope.lines() - 10 - kLags; ++l) {
          if (pass == 0) {
            mean += intensity(k, l);
            count += 1.0;
            continue;
          }
          const double here = intensity(k, l) - mean;
          for (int lag = 0; lag < kLags; ++lag) {
            const auto n = static_cast<std::size_t>(lag);
            along[n] += here * (intensity(k + lag, l) - mean);
            across[n] += here * (intensity(k, l + lag) - mean);
          }
        }
      }
    }
    if (pass == 0) mean /= count;
  }
  return {2.0 * HalfWidth(along), 2.0 * HalfWidth(across)};
}

/// Full widths at half maximum of the echo of a thin wire across the plane in the focus.
Widths PointAtTheFocus(BeamRenderer& renderer) {
  image::NeedleInImage wire;
  wire.tip_in_ct_mm = {15.0, 20.5, 40.0};
  wire.axis_in_ct = -Eigen::Vector3d::UnitZ();
  wire.length_mm = 60.0;
  wire.radius_mm = 0.02;
  image::GrayImage image;
  renderer.Render(FaceAt(15.0, 0.5, 60.0), wire, image, 2);
  const slicing::BeamImage& envelope = renderer.envelope();
  int row = 0;
  int line = 0;
  for (int k = 100; k < envelope.samples() - 40; ++k) {
    for (int l = 20; l < envelope.lines() - 20; ++l) {
      if (envelope.row(k)[l] > envelope.row(row)[line]) row = k, line = l;
    }
  }
  const auto width = [&](int down, int aside) {
    std::vector<double> before;
    std::vector<double> behind;
    for (int n = 0; n < 20; ++n) {
      before.push_back(envelope.row(row - n * down)[line - n * aside]);
      behind.push_back(envelope.row(row + n * down)[line + n * aside]);
    }
    return HalfWidth(before) + HalfWidth(behind);
  };
  return {width(1, 0), width(0, 1)};
}

// The intensity of speckle is correlated over the width of the point spread's amplitude (both
// Gaussian): the covariance is the square of the field's, exp(-x^2 / (2 sigma^2)).
TEST(BeamSpeckle, IsCorrelatedOverThePointSpreadWhichIsThatOfTheAperture) {
  acoustics::TissueAcousticsTable table =
      TableOf({{"liver", Scattering()}, {"clear", testing_support::Clear()}});
  const auto labels = UltrasoundSpeckleHomogeneous();
  volume::LabelMap clear = labels;
  clear.names[1] = "clear";
  acoustics::Probe probe = TargetProbe();
  probe.samples_per_line = 1201;  // 0.033 mm
  probe.scan_lines = 257;         // 0.1 mm
  BeamOptions options = SpeckleOnly();
  BeamRenderer speckle({.labels = &labels, .acoustics = &table}, probe, options);
  BeamRenderer point({.labels = &clear, .acoustics = &table}, probe, options);
  const Widths correlated = CorrelationAtTheFocus(speckle);
  const Widths spread = PointAtTheFocus(point);
  const double step_mm = speckle.grid().step_mm;
  const double line_mm = speckle.grid().LateralSpacingMm(0);
  EXPECT_NEAR(correlated.along / spread.along, 1.0, 0.05)
      << correlated.along * step_mm << " mm of " << spread.along * step_mm;
  EXPECT_NEAR(correlated.across / spread.across, 1.0, 0.05)
      << correlated.across * line_mm << " mm of " << spread.across * line_mm;
  EXPECT_NEAR(spread.along * step_mm / kPulseMm, 1.0, 0.10);
  EXPECT_NEAR(spread.across * line_mm / kBeamMm, 1.0, 0.10);
}

TEST(BeamSpeckle, ALesionHasItsContrast) {
  for (const double contrast_db : {-9.0, -3.0, 6.0}) {
    const auto table =
        TableOf({{"liver", Scattering(-30.0)}, {"lesion", Scattering(-30.0 + contrast_db)}});
    const auto labels = LabelledBlock({60, 90, 200}, 0.5, {{1, "liver"}, {2, "lesion"}},
                                      [](double x, double y, double) -> volume::Label {
                                        return std::hypot(x - 15.0, y - 20.0) < 7.0 ? 2 : 1;
                                      });
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, TargetProbe(), SpeckleOnly());
    double inside = 0.0;
    double outside = 0.0;
    double count_inside = 0.0;
    double count_outside = 0.0;
    image::GrayImage image;
    for (double z_mm = 2.0; z_mm < 98.0; z_mm += kApartMm) {
      renderer.Render(FaceAt(15.0, 0.0, z_mm), std::nullopt, image, 2);
      const slicing::BeamImage& envelope = renderer.envelope();
      for (int k = 80; k < 320; ++k) {
        for (int l = 4; l < 125; ++l) {
          const Eigen::Vector2d start = renderer.grid().start_mm[static_cast<std::size_t>(l)];
          const double r = std::hypot(start.x(), k * renderer.grid().step_mm - 20.0);
          const double value = double{envelope.row(k)[l]} * envelope.row(k)[l];
          if (r < 5.0) inside += value, count_inside += 1.0;
          if (r > 9.0) outside += value, count_outside += 1.0;
        }
      }
    }
    EXPECT_NEAR(10.0 * std::log10(inside / count_inside * count_outside / outside), contrast_db,
                0.5);
  }
}

/// Tissue pressed together along the beam: what is now at y was at y (1 + strain).
class Squeeze : public slicing::RestMap {
 public:
  explicit Squeeze(double strain) : strain_(strain) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_mm,
                             const Eigen::Vector3d&) const noexcept override {
    return {place_mm.x(), place_mm.y() * (1.0 + strain_), place_mm.z()};
  }
  double SpacingMm() const noexcept override { return 2.0; }

 private:
  double strain_;
};

/// By how much the piece of a line around `k` has moved up, samples with fraction.
double Moved(const slicing::BeamImage& before, const slicing::BeamImage& after, int line, int k,
             int most) {
  constexpr int kHalf = 40;
  std::vector<double> match;
  for (int lag = -1; lag <= most + 1; ++lag) {
    double ab = 0.0;
    double a_sum = 0.0;
    double b_sum = 0.0;
    double aa = 0.0;
    double bb = 0.0;
    for (int n = -kHalf; n <= kHalf; ++n) {
      const double a = before.row(k + n)[line];
      const double b = after.row(k + n - lag)[line];
      a_sum += a;
      b_sum += b;
      ab += a * b;
      aa += a * a;
      bb += b * b;
    }
    const double count = 2.0 * kHalf + 1.0;
    match.push_back((ab - a_sum * b_sum / count) /
                    std::sqrt((aa - a_sum * a_sum / count) * (bb - b_sum * b_sum / count)));
  }
  std::size_t best = 1;
  for (std::size_t n = 1; n + 1 < match.size(); ++n) {
    if (match[n] > match[best]) best = n;
  }
  const double curvature = match[best - 1] - 2.0 * match[best] + match[best + 1];
  return static_cast<double>(best) - 1.0 + 0.5 * (match[best - 1] - match[best + 1]) / curvature;
}

TEST(BeamSpeckle, TrackedSpeckleGivesTheStrain) {
  const auto table = TableOf({{"liver", Scattering()}});
  const auto labels = UltrasoundSpeckleHomogeneous();
  acoustics::Probe probe = TargetProbe();
  probe.samples_per_line = 801;  // 0.05 mm
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, SpeckleOnly());
  for (const double strain : {0.005, 0.02}) {
    const Squeeze squeeze(strain);
    std::vector<double> depth;
    std::vector<double> moved;
    for (double z_mm = 2.0; z_mm < 98.0; z_mm += 4.0 * kApartMm) {
      image::GrayImage image;
      renderer.Render(FaceAt(15.0, 0.0, z_mm), std::nullopt, image, 2);
      const slicing::BeamImage before = [&] {
        slicing::BeamImage copy;
        const slicing::BeamImage& envelope = renderer.envelope();
        copy.Resize(envelope.lines(), envelope.samples());
        for (int k = 0; k < envelope.samples(); ++k) {
          std::copy_n(envelope.row(k), envelope.lines(), copy.row(k));
        }
        return copy;
      }();
      renderer.Render(FaceAt(15.0, 0.0, z_mm), std::nullopt, image, 2, &squeeze);
      const slicing::BeamImage& after = renderer.envelope();
      for (int l = 8; l < 121; l += 3) {
        for (int k = 100; k < 700; k += 25) {
          const int most = static_cast<int>(strain * k) + 2;
          // Where a window sits in the pressed tissue is half of its way further up.
          const double way = Moved(before, after, l, k, most);
          depth.push_back(k - way);
          moved.push_back(way);
        }
      }
    }
    EXPECT_NEAR(testing_support::StraightLine(depth, moved).slope / strain, 1.0, 0.02) << strain;
  }
}

TEST(BeamNeedle, IsGoneOneAndAHalfSlicesFromThePlane) {
  const auto table = TableOf({{"liver", Scattering()}});
  const auto labels = UltrasoundSpeckleHomogeneous();
  acoustics::Probe probe = TargetProbe();
  probe.elevation_aperture_mm = 5.0;
  probe.elevation_focus_mm = 20.0;
  // In the focus of the lens, there and back: 0.886 lambda times focus over aperture.
  const double slice_mm = 0.886 * kLambdaMm * 20.0 / 5.0;
  BeamOptions options;
  options.elevation_planes = 5;
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, options);
  const auto shown = [&](std::optional<double> beside_mm) {
    std::optional<image::NeedleInImage> needle;
    if (beside_mm) {
      needle.emplace();
      needle->tip_in_ct_mm << 20.0, 20.5, 50.0 + *beside_mm;
      needle->axis_in_ct = Eigen::Vector3d::UnitX();
      needle->length_mm = 40.0;
      needle->radius_mm = 0.2;
    }
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 50.0), needle, image, 2);
    return image;
  };
  const auto most = [](const image::GrayImage& a, const image::GrayImage& b) {
    int difference = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n) {
      difference = std::max(difference, std::abs(a.pixels[n] - b.pixels[n]));
    }
    return difference;
  };
  const image::GrayImage without = shown(std::nullopt);
  EXPECT_GT(most(without, shown(0.0)), 50);
  EXPECT_GT(most(without, shown(0.4 * slice_mm)), 20);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_LE(most(without, shown(side * (1.5 * slice_mm + 0.2))), 1);
  }
}

}  // namespace
}  // namespace acus::ultrasound
