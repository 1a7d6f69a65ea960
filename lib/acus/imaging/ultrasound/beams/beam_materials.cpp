#include "acus/imaging/ultrasound/beams/beam_materials.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"

namespace acus::ultrasound {
namespace {

/// dB/cm one way to nepers of amplitude per sample, two-way.
double NepersPerSample(double db_per_cm, double step_mm) {
  return db_per_cm * 0.1 * step_mm * 2.0 * std::numbers::ln10 / 20.0;
}

}  // namespace

struct BeamMaterials::Values {
  double log_impedance;
  double nepers;
  double scatter;
};

double BeamMaterials::StepMm(const acoustics::TissueAcoustics& tissue) const {
  // At their time of flight, samples are further apart where sound is faster.
  return time_of_flight_ ? step_mm_ * tissue.speed_m_per_s / acoustics::kScannerSpeedMPerS
                         : step_mm_;
}

BeamMaterials::Values BeamMaterials::ValuesOf(const acoustics::TissueAcoustics& tissue) const {
  Values values{};
  values.log_impedance = 0.5 * std::log(tissue.impedance_mrayl);
  if (attenuation_) {
    values.nepers = NepersPerSample(tissue.AttenuationDbPerCm(frequency_mhz_), StepMm(tissue));
  }
  // Scatterers in the length of the pulse add their intensities.
  if (speckle_) {
    values.scatter = std::sqrt(pulse_mm_ * std::pow(10.0, tissue.backscatter_db / 10.0));
  }
  return values;
}

BeamMaterials::BeamMaterials(const BeamTissue& tissue, const BeamOptions& options,
                             const acoustics::Probe& probe, double step_mm)
    // The second harmonic is made of the square of what is sent, so that it is lost on both ways
    // as sound of twice the frequency is, where attenuation grows with the frequency.
    : frequency_mhz_(acoustics::ReceivedMhz(probe)),
      step_mm_(step_mm),
      // The integral of exp(-z^2 / sigma^2), the pulse squared.
      pulse_mm_(acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe)) *
                std::sqrt(std::numbers::pi)),
      time_of_flight_(options.time_of_flight),
      attenuation_(options.attenuation),
      speckle_(options.speckle) {
  ACUS_REQUIRE(tissue.acoustics != nullptr, "beams: no table of tissue acoustics is given");
  MakeCurves(*tissue.acoustics);
  if (tissue.labels == nullptr) return;
  const acoustics::LabelAcoustics labels =
      acoustics::AcousticsOfLabels(*tissue.acoustics, *tissue.labels, tissue.labels_file);
  for (std::size_t n = 0; n < labels.of.size(); ++n) {
    const Values values = ValuesOf(labels.of[n]);
    log_impedance_[n] = static_cast<float>(values.log_impedance);
    decay_[n] = static_cast<float>(std::exp(-values.nepers));
    scatter_[n] = static_cast<float>(values.scatter);
    speed_[n] = labels.of[n].speed_m_per_s;
  }
  for (const auto& [name, direction] : tissue.fibres_in_ct) {
    ACUS_REQUIRE(direction.allFinite() && direction.norm() > 1e-9, "beams: fibres of ", name,
                 " have no direction");
    for (const auto& [label, label_name] : tissue.labels->names) {
      if (label_name != name) continue;
      const acoustics::TissueAcoustics& of = labels.of[label];
      FibreLabel fibre{.label = label, .direction_in_ct = direction.normalized()};
      if (attenuation_) {
        fibre.extra_nepers_per_sample =
            NepersPerSample(of.AttenuationDbPerCm(frequency_mhz_, 1.0), StepMm(of)) -
            NepersPerSample(of.AttenuationDbPerCm(frequency_mhz_, 0.0), StepMm(of));
      }
      if (options.fibre_texture && speckle_) fibre.ratio = of.fibre_ratio;
      fibres_.push_back(fibre);
    }
  }
}

void BeamMaterials::MakeCurves(const acoustics::TissueAcousticsTable& table) {
  const std::size_t count = table.by_hu.size();
  ACUS_REQUIRE(count >= 1 && count <= kernels::TissueCurves::kMaxKnots, table.file,
               ": /by_hu: ", count, " knots; the beam renderer takes 1 to ",
               kernels::TissueCurves::kMaxKnots);
  std::vector<Values> values;
  for (const acoustics::HuTissue& knot : table.by_hu) {
    const acoustics::TissueAcoustics& tissue = table.Of(knot.tissue);
    values.push_back(ValuesOf(tissue));
    hu_.push_back(knot.hu);
    speed_at_hu_.push_back(tissue.speed_m_per_s);
  }
  curves_.num_knots = static_cast<int>(count);
  const auto set = [&](int curve, double Values::*value) {
    curves_.first_value[curve] = static_cast<float>(values[0].*value);
    double slope = 0.0;
    for (std::size_t n = 0; n < count; ++n) {
      const double next =
          n + 1 < count ? (values[n + 1].*value - values[n].*value) / (hu_[n + 1] - hu_[n]) : 0.0;
      curves_.hu_knot[n] = static_cast<float>(hu_[n]);
      curves_.slope_change[curve][n] = static_cast<float>(next - slope);
      slope = next;
    }
  };
  set(0, &Values::log_impedance);
  set(1, &Values::nepers);
  set(2, &Values::scatter);
}

void BeamMaterials::TurnFibres(const Eigen::Matrix3d& lattice_from_ct, double grain_mm) {
  const Eigen::Matrix3d lattice_from_grains = lattice_from_ct * grain_mm;
  for (FibreLabel& fibre : fibres_) {
    fibre.grain_in_lattice = lattice_from_grains * fibre.direction_in_ct;
    fibre.dual_in_lattice = lattice_from_grains.inverse().transpose() * fibre.direction_in_ct;
  }
}

float BeamMaterials::MostScatter() const {
  float most = *std::max_element(scatter_.begin(), scatter_.end());
  float at_knot = curves_.first_value[2];
  float slope = 0.0F;
  for (int n = 0; n < curves_.num_knots; ++n) {
    if (n > 0) at_knot += slope * (curves_.hu_knot[n] - curves_.hu_knot[n - 1]);
    slope += curves_.slope_change[2][n];
    most = std::max(most, at_knot);
  }
  return most;
}

double BeamMaterials::SpeedAtHu(double hu) const {
  if (hu <= hu_.front()) return speed_at_hu_.front();
  for (std::size_t n = 1; n < hu_.size(); ++n) {
    if (hu > hu_[n]) continue;
    const double share = (hu - hu_[n - 1]) / (hu_[n] - hu_[n - 1]);
    return speed_at_hu_[n - 1] + share * (speed_at_hu_[n] - speed_at_hu_[n - 1]);
  }
  return speed_at_hu_.back();
}

}  // namespace acus::ultrasound
