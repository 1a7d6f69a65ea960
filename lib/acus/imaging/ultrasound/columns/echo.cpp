#include "acus/imaging/ultrasound/columns/echo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/imaging/ultrasound/display/coupling.h"

namespace acus::ultrasound {
namespace {

constexpr int kLanesPerPiece = slicing::BeamBend::kMaxLanes;
constexpr float kMetalAboveHu = 3500.0F;  ///< Beyond bone and the 12 bits of a CT: only the needle.

enum WorkRow { kEnergy, kReflected, kWeight, kScattered, kNepers, kFirstImpedance };

std::vector<HuKnot> Scaled(std::vector<HuKnot> knots, double factor) {
  for (HuKnot& knot : knots) knot.value *= factor;
  return knots;
}

std::vector<HuKnot> FromDecibel(std::vector<HuKnot> knots, double factor) {
  for (HuKnot& knot : knots) knot.value = factor * std::pow(10.0, knot.value / 10.0);
  return knots;
}

float ValueOf(const slicing::kernels::Curve& curve, float hu) {
  float value = curve.first_value;
  for (int n = 0; n < curve.num_knots; ++n) {
    value += curve.slope_change[n] * std::max(0.0F, hu - curve.hu_knot[n]);
  }
  return value;
}

}  // namespace

slicing::kernels::Curve CurveOf(const std::vector<HuKnot>& knots) {
  ACUS_REQUIRE(!knots.empty() && knots.size() <= slicing::kernels::Curve::kMaxKnots,
               "a curve over HU has ", knots.size(), " knots; allowed is 1 to ",
               slicing::kernels::Curve::kMaxKnots);
  slicing::kernels::Curve curve;
  curve.num_knots = static_cast<int>(knots.size());
  curve.first_value = static_cast<float>(knots[0].value);
  double slope = 0.0;
  for (std::size_t n = 0; n < knots.size(); ++n) {
    double next_slope = 0.0;
    if (n + 1 < knots.size()) {
      const double width = knots[n + 1].hu - knots[n].hu;
      ACUS_REQUIRE(width > 0.0, "a curve over HU has a knot at ", knots[n + 1].hu,
                   " HU after one at ", knots[n].hu, " HU; sort them");
      next_slope = (knots[n + 1].value - knots[n].value) / width;
    }
    curve.hu_knot[n] = static_cast<float>(knots[n].hu);
    curve.slope_change[n] = static_cast<float>(next_slope - slope);
    slope = next_slope;
  }
  return curve;
}

EchoTracer::EchoTracer(const acoustics::ScanGrid& grid, double frequency_mhz,
                       const BModeOptions& options, const volume::Geometry& ct_geometry)
    : options_(options), grid_(grid) {
  ACUS_REQUIRE(options.angle_exponent >= 0 && options.angle_exponent <= 2, "angle_exponent: is ",
               options.angle_exponent, "; allowed is 0, 1 or 2");
  ACUS_REQUIRE(options.boosted_reflection > 0.0 && options.boosted_reflection <= 1.0,
               "boosted_reflection: is ", options.boosted_reflection, "; allowed is above 0 to 1");
  ACUS_REQUIRE(options.needle_reflection > 0.0 && options.needle_reflection <= 1.0,
               "needle_reflection: is ", options.needle_reflection, "; allowed is above 0 to 1");
  impedance_ = CurveOf(options.impedance_mrayl);
  span_ = std::max(1, static_cast<int>(std::lround(options.interface_span_mm / grid.step_mm)));
  span_ = std::min(span_, grid.samples);
  echo_row_.share_per_sample = 1.0F / static_cast<float>(span_);
  echo_row_.threshold = static_cast<float>(options.shadow_threshold);
  // The samples of one interface together reflect what is required, whatever their number: a strong
  // one is seen from its surface on, by the second half of them.
  const int second_half = span_ - span_ / 2;
  const auto per_sample = [&](double reflection) {
    return static_cast<float>(1.0 - std::pow(1.0 - reflection, 1.0 / second_half));
  };
  echo_row_.boosted_per_sample = per_sample(options.boosted_reflection);
  echo_row_.metal_per_sample = per_sample(options.needle_reflection);
  echo_row_.metal_impedance = ValueOf(impedance_, kMetalAboveHu);
  if (options.angle_exponent > 0) {
    for (int k = 0; k < grid.samples; ++k) {
      const double spacing = grid.lines() > 1 ? grid.LateralSpacingMm(k) : 1.0;
      // The lines of a phased probe start at one place.
      per_two_lateral_mm_.push_back(
          static_cast<float>(0.5 / std::max(spacing, 1e-3 * grid.step_mm)));
    }
  }
  if (options.attenuation) {
    // dB/cm/MHz, one way, to nepers of intensity per sample, two-way.
    const double factor = frequency_mhz * 0.1 * grid.step_mm * 2.0 * std::numbers::ln10 / 10.0;
    nepers_ = CurveOf(Scaled(options.attenuation_db_per_cm_mhz, factor));
  }
  if (options.texture) {
    scatter_ = CurveOf(FromDecibel(options.backscatter_db, grid.step_mm));
    MakeTile(options.texture_grain_mm, ct_geometry, options.seed);
  }
}

void EchoTracer::MakeTile(double grain_mm, const volume::Geometry& ct_geometry,
                          std::uint64_t seed) {
  ACUS_REQUIRE(grain_mm > 0.0, "texture_grain_mm: is ", grain_mm, "; it must be above 0");
  // Fully developed speckle: the intensity of a complex normal field is exponentially distributed.
  constexpr int kLog2Size = 7;
  constexpr float kUnit = 1.0F / 64.0F;  // Amplitudes to 4 times the root mean square fit a byte.
  tile_data_.resize((std::size_t{1} << (3 * kLog2Size)) + 4);
  RandomStream random(seed, "speckle tile");
  for (std::uint8_t& byte : tile_data_) {
    const double amplitude = std::sqrt(-std::log(1.0 - random.Uniform()));
    byte = static_cast<std::uint8_t>(std::min(255.0, std::round(amplitude / kUnit)));
  }
  tile_ = {.data = tile_data_.data(), .log2_size = kLog2Size, .per_index = {}, .unit = kUnit};
  for (int a = 0; a < 3; ++a) {
    tile_.per_index[a] = static_cast<float>(ct_geometry.spacing_mm[a] / grain_mm);
  }
}

void EchoTracer::StartEnergy(const slicing::BeamImage& hu) {
  float* energy = work_.row(kEnergy);
  for (int l = 0; l < slicing::kernels::RoundUp(hu.lines()); ++l) {
    // A face against air radiates nothing into the body (it reflects 99.9 %, each way).
    energy[l] = hu.row(0)[l] < kAirBelowHu ? 0.0F : 1.0F;
  }
}

const float* EchoTracer::ScatterRow(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                                    const slicing::BeamImage& hu, int k, int first_lane,
                                    int lanes) {
  float* scattered = work_.row(kScattered) + first_lane;
  slicing::kernels::CurveRow(scatter_, hu.row(k) + first_lane, lanes, scattered);
  slicing::BeamBend::Row row;
  float sample = 0.0F;
  const slicing::kernels::Lines placed = bend.PlaceRow(lines, k, first_lane, lanes, row, sample);
  slicing::kernels::TextureRow(tile_, placed, sample, lanes, scattered);
  return scattered;
}

void EchoTracer::TracePiece(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                            const slicing::BeamImage& hu, slicing::BeamImage& echo, int first_lane,
                            int lanes) {
  const int last = hu.samples() - 1;
  // Impedances of the last span_ + 1 rows, in a ring.
  const auto impedance = [&](int k) {
    return work_.row(kFirstImpedance + std::clamp(k, 0, last) % (span_ + 1)) + first_lane;
  };
  float* energy = work_.row(kEnergy) + first_lane;
  float* reflected = work_.row(kReflected) + first_lane;
  int next_impedance = 0;
  for (int k = 0; k <= last; ++k) {
    const int below = k + span_ / 2;
    for (; next_impedance <= std::min(below, last); ++next_impedance) {
      slicing::kernels::CurveRow(impedance_, hu.row(next_impedance) + first_lane, lanes,
                                 impedance(next_impedance));
    }
    slicing::kernels::ReflectRow(echo_row_, impedance(below - span_), impedance(k),
                                 impedance(below), lanes, reflected);
    const float* weight = nullptr;
    if (options_.angle_exponent > 0) {
      const int a = std::max(0, below - span_);
      const int b = std::min(last, below);
      const slicing::kernels::AngleRow row{
          .above = hu.row(a) + first_lane,
          .here = hu.row(k) + first_lane,
          .below = hu.row(b) + first_lane,
          .per_two_axial_mm = static_cast<float>(1.0 / (std::max(1, b - a) * grid_.step_mm)),
          .per_two_lateral_mm = per_two_lateral_mm_[static_cast<std::size_t>(k)],
          .exponent = options_.angle_exponent};
      slicing::kernels::AngleRowWeights(row, lanes, work_.row(kWeight) + first_lane);
      weight = work_.row(kWeight) + first_lane;
    }
    const float* scattered =
        options_.texture ? ScatterRow(lines, bend, hu, k, first_lane, lanes) : nullptr;
    slicing::kernels::PropagateRow(reflected, weight, scattered, lanes, energy,
                                   echo.row(k) + first_lane);
    if (options_.attenuation) {
      float* nepers = work_.row(kNepers) + first_lane;
      slicing::kernels::CurveRow(nepers_, hu.row(k) + first_lane, lanes, nepers);
      slicing::kernels::AttenuateRow(nepers, lanes, energy);
    }
  }
}

void EchoTracer::Trace(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                       slicing::BeamImage& hu, slicing::BeamImage& echo, int num_threads) {
  echo.Resize(hu.lines(), hu.samples());
  work_.Resize(hu.lines(), kFirstImpedance + span_ + 1);
  FillCouplingGap(options_.coupling_gap_mm, grid_.step_mm, hu);
  if (options_.angle_exponent > 0) {
    for (int k = 0; k < hu.samples(); ++k) hu.FillMargins(k);
  }
  StartEnergy(hu);
  const int all_lanes = slicing::kernels::RoundUp(hu.lines());
  const auto piece = [&](int p) {
    const int first = p * kLanesPerPiece;
    TracePiece(lines, bend, hu, echo, first, std::min(kLanesPerPiece, all_lanes - first));
  };
  ParallelFor((all_lanes + kLanesPerPiece - 1) / kLanesPerPiece, num_threads, std::ref(piece));
}

}  // namespace acus::ultrasound
