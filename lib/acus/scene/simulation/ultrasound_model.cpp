#include "acus/scene/simulation/ultrasound_model.h"

namespace acus::simulation {
namespace {

using Renderer = UltrasoundModel::Renderer;

/// The gain of a preset with TGC is that of beam space, where a perfect reflector echoes 0 dB. In
/// the columns of 2010 echoes are shares of a column without attenuation by depth: 14 dB less and
/// no TGC show the same tissue at the same grey.
acoustics::Probe ForColumns(acoustics::Probe probe) {
  constexpr double kLessGainDb = 14.0;
  if (probe.tgc_db_per_cm <= 0.0) return probe;
  probe.gain_db -= kLessGainDb;
  probe.tgc_db_per_cm = 0.0;
  return probe;
}

/// Constructs the renderer for each type of settings.
struct MakeRenderer {
  const ImagePatient& patient;
  const acoustics::Probe& probe;

  Renderer operator()(const ultrasound::VidalOptions& options) const {
    return Renderer(std::in_place_type<ultrasound::VidalRenderer>, *patient.ct, probe, options);
  }
  Renderer operator()(const ultrasound::AlamillaOptions& options) const {
    return Renderer(std::in_place_type<ultrasound::AlamillaRenderer>, *patient.labels, probe,
                    options, patient.triangles);
  }
  Renderer operator()(const ultrasound::BModeOptions& options) const {
    return Renderer(std::in_place_type<ultrasound::BModeRenderer>, *patient.ct, ForColumns(probe),
                    options);
  }
  Renderer operator()(const BeamSettings& settings) const {
    const ultrasound::BeamTissue tissue{.ct = settings.from_ct ? patient.ct : nullptr,
                                        .labels = settings.from_labels ? patient.labels : nullptr,
                                        .acoustics = &settings.acoustics,
                                        .fibres_in_ct = settings.fibres_in_ct};
    return Renderer(std::in_place_type<ultrasound::BeamRenderer>, tissue, probe, settings.options);
  }
  Renderer operator()(const ApertureSettings& settings) const {
    const ultrasound::BeamTissue tissue{.ct = settings.from_ct ? patient.ct : nullptr,
                                        .labels = settings.from_labels ? patient.labels : nullptr,
                                        .acoustics = &settings.acoustics,
                                        .fibres_in_ct = settings.fibres_in_ct};
    return Renderer(std::in_place_type<ultrasound::ApertureRenderer>, tissue, probe,
                    settings.options, 2, settings.store.get());
  }
};

template <typename Options>
Options Seeded(Options options, std::uint64_t seed) {
  options.seed = seed;
  return options;
}

/// A table of greys applies at the preset's gain: gain acts relative to that.
template <typename Options>
Options HeldFor(const acoustics::Probe& probe, Options options) {
  options.gain_of_table_db = probe.gain_db;
  return options;
}

}  // namespace

ImageSettings ReadImageSettings(const scenario::UltrasoundEffect& effect,
                                const acoustics::Probe& probe, const volume::LabelMap* labels) {
  switch (effect.model) {
    case scenario::UltrasoundModel::kVidal2008:
      return HeldFor(probe, Seeded(ultrasound::ReadVidalOptions(effect.acoustics), effect.seed));
    case scenario::UltrasoundModel::kAlamilla2021: {
      auto options = ultrasound::ReadAlamillaOptions(effect.acoustics);
      options.displaces_pixels = effect.displaces_pixels;
      return HeldFor(probe, Seeded(std::move(options), effect.seed));
    }
    case scenario::UltrasoundModel::kBeams:
      return ReadBeamSettings(effect, labels);
    case scenario::UltrasoundModel::kAperture:
      return ReadApertureSettings(effect, labels);
    case scenario::UltrasoundModel::kColumns2010:
      break;
  }
  return Seeded(ultrasound::ReadBModeOptions(effect.acoustics), effect.seed);
}

const ultrasound::DisplayOptions* DisplayOf(const ImageSettings& settings) {
  if (const auto* beams = std::get_if<BeamSettings>(&settings)) return &beams->options.display;
  const auto* aperture = std::get_if<ApertureSettings>(&settings);
  return aperture != nullptr ? &aperture->options.display : nullptr;
}

UltrasoundModel::UltrasoundModel(const ImagePatient& patient, const acoustics::Probe& probe,
                                 const ImageSettings& settings)
    : renderer_(std::visit(MakeRenderer{patient, probe}, settings)) {}

void UltrasoundModel::Render(const Eigen::Isometry3d& ct_from_probe,
                             const std::optional<image::NeedleInImage>& needle,
                             image::GrayImage& out, int num_threads, const slicing::RestMap* rest) {
  std::visit([&](auto& r) { r.Render(ct_from_probe, needle, out, num_threads, rest); }, renderer_);
}

const image::ImageGeometry& UltrasoundModel::image() const {
  return std::visit(
      [](const auto& r) -> const auto& { return r.image(); }, renderer_);
}

}  // namespace acus::simulation
