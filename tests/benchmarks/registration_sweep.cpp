#include "benchmarks/registration_sweep.h"

#include <cmath>
#include <functional>
#include <numeric>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/random.h"
#include "acus/base/core/text_table.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "benchmarks/breathing_body.h"

namespace acus::benchmarks {
namespace {

using breathing_registration::RegistrationSettings;
using Eigen::Vector3d;

constexpr double kHalfWay = 0.5;  ///< Of the cycle: end expiration.
constexpr double kRegistrationSweepOffWallMm = 15.0;
constexpr double kNoiseHu = 10.0;
/// The part that is scanned: across the wall on the right, as high as the organs move.
const Vector3d kLowMm(40.0, -80.0, -90.0);
const Vector3d kHighMm(176.0, 80.0, 90.0);

/// Texture of tissue at rest, HU: organs and wall have their own.
double HuAt(const Vector3d& p) {
  const bool inside = BreathingBody::FromWallMm(p) < 0.0;
  double hu = inside ? 45.0 : -20.0;
  const double phase = inside ? 0.0 : 1.3;
  hu += 45.0 * std::sin(p.x() / 7.0 + phase) * std::sin(p.y() / 6.0) * std::sin(p.z() / 8.0);
  hu += 40.0 * std::sin(0.6 * p.x() / 4.0 + 0.5 * p.z() / 4.0 + phase);
  hu += 35.0 * std::cos(0.4 * p.y() / 3.0 - 0.7 * p.z() / 3.5);
  return hu;
}

/// Where tissue that has come to `world_mm` was. Side by side with the wall: what slides in the
/// cavity stays in it.
Vector3d RestOf(const Vector3d& world_mm) {
  const auto breath = BreathingBody::BreathAt(kHalfWay);
  Vector3d rest_mm = world_mm;
  for (int n = 0; n < 12; ++n) rest_mm = world_mm - BreathingBody::DisplacementMm(breath, rest_mm);
  return rest_mm;
}

class RegistrationSweeper {
 public:
  RegistrationSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        voxel_mm_(quick ? 6.0 : 3.0),
        reference_(BreathingBodyCt(voxel_mm_, false, kNoiseHu, 0)),
        phase_(BreathingBodyCt(voxel_mm_, true, kNoiseHu, 1)) {
    RandomStream random(1, "registration places");
    while (places_.size() < 1500) {
      Vector3d place;
      for (int d = 0; d < 3; ++d) place[d] = random.Uniform(kLowMm[d] + 20.0, kHighMm[d] - 20.0);
      const double from_wall_mm = BreathingBody::FromWallMm(place);
      if (from_wall_mm < 0.0) places_.push_back(place);
    }
  }

  std::vector<Row> Run() {
    const std::vector<double> spacings =
        quick_ ? std::vector{6.0, 12.0} : std::vector{3.0, 4.5, 6.0, 9.0, 12.0};
    Turn("spacing_mm", spacings, voxel_mm_,
         [](RegistrationSettings& s, double v) { s.spacing_mm = v; });
    Turn("levels", {1, 2, 3}, 3,
         [](RegistrationSettings& s, double v) { s.levels = static_cast<int>(v); });
    Turn("iterations", quick_ ? std::vector{1.0, 6.0} : std::vector{1.0, 2.0, 4.0, 6.0, 12.0}, 6,
         [](RegistrationSettings& s, double v) { s.iterations = static_cast<int>(v); });
    Turn("solver_iterations", quick_ ? std::vector{25.0} : std::vector{5.0, 10.0, 25.0, 50.0}, 25,
         [](RegistrationSettings& s, double v) { s.solver_iterations = static_cast<int>(v); });
    Turn("smoothness",
         quick_ ? std::vector{0.01, 0.3, 1.0, 100.0} : std::vector{0.01, 0.1, 0.3, 1.0, 3.0, 10.0},
         0.3, [](RegistrationSettings& s, double v) { s.smoothness = v; });
    Wall();
    return std::move(rows_);
  }

 private:
  void Turn(const char* knob, const std::vector<double>& values, double usual,
            const std::function<void(RegistrationSettings&, double)>& turn) {
    for (const double value : values) {
      RegistrationSettings settings;
      turn(settings, value);
      Add(knob, RoundedText(value, 3), settings, true, value == usual);
    }
  }

  /// What knowing the wall is worth.
  void Wall() {
    for (const bool known : {false, true}) {
      Add("wall", known ? "slides" : "nothing slides", {}, known, known);
    }
  }

  void Add(const char* knob, const std::string& value, const RegistrationSettings& settings,
           bool wall, bool is_default) {
    context_.Checkpoint(std::string(knob) + " " + value,
                        std::min(0.99, 0.02 * static_cast<double>(rows_.size())));
    RunContext quiet;
    quiet.stop = context_.stop;
    breathing_registration::Tissue tissue{.is_tissue = [](const Vector3d&) { return true; },
                                          .wall_mm = {}};
    if (wall) tissue.wall_mm = BreathingBody::FromWallMm;
    const double begin_s = ThreadCpuSeconds();
    const breathing_registration::PhaseRegistration registration(reference_, tissue, settings,
                                                                 quiet);
    const breathing_registration::PhaseField field = registration.Register(phase_, nullptr, quiet);
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = "phase to reference";
    row.reference = "exact motion";
    row.preparation_s = ThreadCpuSeconds() - begin_s;
    row.memory_mb = 1e-6 * static_cast<double>(field.displacement_voxels().size() *
                                               sizeof(field.displacement_voxels()[0]));
    row.is_default = is_default;
    AddErrors(std::move(row), field, wall);
  }

  void AddErrors(Row row, const breathing_registration::PhaseField& field, bool wall) {
    const auto breath = BreathingBody::BreathAt(kHalfWay);
    std::vector<double> away_mm, near_mm;
    for (const Vector3d& place : places_) {
      const auto side =
          wall ? breathing_registration::Side::kCavity : breathing_registration::Side::kWall;
      const double off_mm =
          (field.DisplacementMm(place, side) - BreathingBody::DisplacementMm(breath, place)).norm();
      (BreathingBody::FromWallMm(place) < -kRegistrationSweepOffWallMm ? away_mm : near_mm)
          .push_back(off_mm);
    }
    const auto mean = [](const std::vector<double>& all) {
      return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
    };
    row.error = mean(away_mm);
    row.error_unit = "mm, more than 15 mm from the sliding wall";
    if (!std::isfinite(row.error)) row.unusable = "the error is not finite";
    rows_.push_back(row);
    row.error = mean(near_mm);
    row.error_unit = "mm, within 15 mm of the sliding wall";
    rows_.push_back(std::move(row));
  }

  bool quick_;
  const RunContext& context_;
  double voxel_mm_;
  volume::CtVolume reference_;
  volume::CtVolume phase_;
  std::vector<Vector3d> places_;
  std::vector<Row> rows_;
};

}  // namespace

volume::CtVolume BreathingBodyCt(double spacing_mm, bool expiration, double noise_hu,
                                 int seed_index) {
  volume::Geometry grid;
  grid.spacing_mm.setConstant(spacing_mm);
  grid.size = ((kHighMm - kLowMm).array() / spacing_mm).cast<int>() + 1;
  grid.origin_mm = kLowMm;
  volume::CtVolume ct(grid);
  RandomStream random(1, "registration noise", static_cast<std::uint64_t>(seed_index));
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vector3d place = ct_from_index * Vector3d(i, j, k);
        const double hu = HuAt(expiration ? RestOf(place) : place);
        const double noise = std::sqrt(3.0) * noise_hu * random.Uniform(-1.0, 1.0);
        ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(hu + noise));
      }
    }
  }
  return ct;
}

Sweep RegistrationSweep() {
  return {"registration", "Finding breath in a 4D CT",
          "A part of the body of the sweep breathing, with texture and noise of 10 HU, is "
          "registered from end inspiration to end expiration, 20 mm. Errors are means against the "
          "exact motion; preparation is one phase.",
          [](bool quick, const RunContext& context) {
            return RegistrationSweeper(quick, context).Run();
          }};
}

}  // namespace acus::benchmarks
