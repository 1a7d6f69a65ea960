// The models of ultrasound behind one interface, from cheap to expensive.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <variant>

#include "acus/data/volume/volume.h"
#include "acus/imaging/slicing/tracing/surface_tracer.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/columns/vidal.h"
#include "acus/scene/scenario/ultrasound_effect.h"
#include "acus/scene/simulation/beam_settings.h"

namespace acus::simulation {

/// Settings of one model. The type selects the model.
using ImageSettings = std::variant<ultrasound::VidalOptions, ultrasound::AlamillaOptions,
                                   ultrasound::BModeOptions, BeamSettings, ApertureSettings>;

/// Reads the settings of the scenario's model. @throws InputError listing all problems.
/// @param probe   Tables of greys apply at its gain.
/// @param labels  Labels of the patient, if the model reads them; else null.
ImageSettings ReadImageSettings(const scenario::UltrasoundEffect& effect,
                                const acoustics::Probe& probe, const volume::LabelMap* labels);

/// The processing of the scanner; null if the model has none.
const ultrasound::DisplayOptions* DisplayOf(const ImageSettings& settings);

/// The patient's data for models; null if the plan does not need it.
struct ImagePatient {
  const volume::CtVolume* ct = nullptr;
  const volume::LabelMap* labels = nullptr;
  const tracing::SurfaceTracer* triangles = nullptr;  ///< In place of labels, for alamilla_2021.
};

/// Renders with the model that the settings belong to. Not for two threads at a time.
class UltrasoundModel {
 public:
  using Renderer = std::variant<ultrasound::VidalRenderer, ultrasound::AlamillaRenderer,
                                ultrasound::BModeRenderer, ultrasound::BeamRenderer,
                                ultrasound::ApertureRenderer>;

  /// Keeps references to the patient, which must outlive this.
  /// @throws InputError if the probe or a setting is out of range.
  UltrasoundModel(const ImagePatient& patient, const acoustics::Probe& probe,
                  const ImageSettings& settings);

  /// As BModeRenderer::Render: allocation-free after the first call, the same bits with any
  /// `num_threads`.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  const image::ImageGeometry& image() const;

 private:
  Renderer renderer_;
};

}  // namespace acus::simulation
