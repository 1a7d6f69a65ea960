// The images of the probe: the slice through the CT, and B-mode.
#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

class CtSliceEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "ct_slice"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    Ports reads;
    if (s.ct_slice) reads = ImageInputs(s, s.ct_slice->needle, {ports::kCt});
    return {ImageStage("CT slice", std::move(reads), {ports::kCtImage})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.ct_slice) return {};
    return {ports::kCtImage};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kCtImage && s.ct_slice;
  }

  void Load(const Scenario& s, Scene& scene, RunContext& /*context*/) const override {
    if (!s.ct_slice) return;
    scene.needle_in_ct_slice = s.ct_slice->needle;
    scene.ct_window = {s.ct_slice->centre_hu, s.ct_slice->width_hu};
  }
};

/// Scan lines of the scenario override those of the preset.
void SetLines(const scenario::UltrasoundEffect& effect, acoustics::Probe& probe) {
  if (effect.scan_lines > 0) probe.scan_lines = effect.scan_lines;
  if (effect.samples_per_line > 0) probe.samples_per_line = effect.samples_per_line;
}

effects::Knob Part(const std::string& model, const char* name, const char* title) {
  return {.name = name,
          .title = title,
          .key = model + "/" + name,
          .acts_on = effects::ActsOn::kImage,
          .values = {false, true}};
}

/// Switches and sampling distances of the beam models.
void AddBeamKnobs(const scenario::UltrasoundEffect& effect, std::vector<effects::Knob>& knobs) {
  using Parts = std::vector<std::pair<const char*, const char*>>;
  const bool is_aperture = effect.model == scenario::UltrasoundModel::kAperture;
  const std::string model = is_aperture ? "aperture" : "beams";
  const Parts parts =
      is_aperture ? Parts{{"angle", "echoes that depend on the angle of the interface"},
                          {"speckle", "scatterers fixed in the tissue"},
                          {"texture", "scatterers that follow the CT"},
                          {"point_spread", "pulse and beam of the probe"},
                          {"reverberation", "echoes that go to the face and back again"},
                          {"refraction", "rays of the aperture that bend with the speed of sound"},
                          {"side_lobes", "side lobes and grating lobes"},
                          {"fibre_texture", "streaks of muscle"},
                          {"clutter", "haze of nearby echoes"},
                          {"noise", "noise of the receiver"}}
                  : Parts{{"angle", "echoes that depend on the angle of the interface"},
                          {"speckle", "scatterers fixed in the tissue"},
                          {"fibre_texture", "speckle that is longer along fibres"},
                          {"point_spread", "pulse and beam of the probe"},
                          {"comet_tail", "ring-down behind gas and within the needle"},
                          {"refraction", "lines that bend by Snell's law"},
                          {"time_of_flight", "samples at their time, by the local speed of sound"},
                          {"multiple_reflections", "echoes between interfaces and the face"}};
  for (const auto& [name, title] : parts) knobs.push_back(Part(model, name, title));
  knobs.push_back({.name = "elevation_planes",
                   .title = "planes over the thickness of the slice",
                   .key = model + "/elevation_planes",
                   .acts_on = effects::ActsOn::kImage,
                   .values = {1, 3, 5, 7, 11, 15}});
  if (!is_aperture) return;
  knobs.push_back({.name = "aperture_rays",
                   .title = "directions over the aperture",
                   .key = "aperture/aperture_rays",
                   .acts_on = effects::ActsOn::kImage,
                   .values = {1, 3, 5, 9, 13, 21, 31}});
}

/// Scan lines and samples of each, which the probe preset sets unless the scenario does.
void AddLineKnobs(const Scenario& s, std::vector<effects::Knob>& knobs) {
  const acoustics::Probe probe = acoustics::ReadProbe(s.probe);
  const scenario::UltrasoundEffect& effect = *s.ultrasound;
  const bool is_fan = effect.model == scenario::UltrasoundModel::kColumns2010 &&
                      probe.kind != acoustics::ProbeKind::kLinear;
  if (!effect.InBeamSpace() && !is_fan) return;
  knobs.push_back({.name = "image_lines",
                   .title = "scan lines of the image",
                   .key = "scan_lines",
                   .acts_on = effects::ActsOn::kImage,
                   .values = {64, 128, 192, 256, 384, 512},
                   .default_value = probe.scan_lines,
                   .scenario_value = effect.scan_lines > 0 ? effect.scan_lines : probe.scan_lines});
  if (!effect.InBeamSpace()) return;
  const int samples =
      effect.samples_per_line > 0 ? effect.samples_per_line : probe.samples_per_line;
  knobs.push_back({.name = "image_samples",
                   .title = "samples of each scan line",
                   .key = "samples_per_line",
                   .acts_on = effects::ActsOn::kImage,
                   .values = {256, 512, 1024, 2048, 4096},
                   .default_value = probe.samples_per_line,
                   .scenario_value = samples});
}

class BModeEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "ultrasound"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    Ports reads;
    if (s.ultrasound) {
      Ports patient;
      if (s.ultrasound->ReadsCt()) patient.push_back(ports::kCt);
      if (s.ultrasound->ReadsLabels()) patient.push_back(ports::kLabels);
      patient.push_back(ports::kAcoustics);
      if (IsWrittenByListed(s, ports::kEcho)) patient.push_back(ports::kEcho);
      reads = ImageInputs(s, s.ultrasound->needle, std::move(patient));
    }
    return {ImageStage("B-mode", std::move(reads), {ports::kBMode})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.ultrasound) return {};
    return {ports::kBMode};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kBMode && s.ultrasound;
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.ultrasound) return {};
    std::vector<effects::Knob> knobs{
        {.name = "ultrasound_model",
         .title = "what makes the B-mode image",
         .key = "model",
         .acts_on = effects::ActsOn::kImage,
         .values = {"vidal_2008", "alamilla_2021", "columns_2010", "beams", "aperture"},
         .papers = {{"vidal_2008", "Vidal-2008"},
                    {"alamilla_2021", "Alamilla-2021"},
                    {"columns_2010", "Augmented-2010"}}}};
    AddLineKnobs(s, knobs);
    if (s.ultrasound->InBeamSpace()) AddBeamKnobs(*s.ultrasound, knobs);
    return knobs;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.ultrasound) return;
    inputs.push_back(File(ports::kAcoustics, s.ultrasound->acoustics, "/effects/ultrasound"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    if (!scene.plan.Writes(ports::kBMode)) return;
    SetLines(*s.ultrasound, *scene.probe);
    scene.needle_in_b_mode = s.ultrasound->needle;
    const bool is_by_labels = scene.plan.Reads(ports::kBMode, ports::kLabels);
    scene.b_mode =
        ReadImageSettings(*s.ultrasound, *scene.probe, is_by_labels ? scene.labels.get() : nullptr);
    context.provenance.AddInput(s.ultrasound->acoustics);
    if (const auto* alamilla = std::get_if<ultrasound::AlamillaOptions>(&*scene.b_mode)) {
      for (const auto& image : alamilla->ExampleImages()) context.provenance.AddInput(image);
    }
    if (s.ultrasound->display.empty()) return;
    context.provenance.AddInput(s.ultrasound->display);
    // The screens of the display define the image's geometry.
    *scene.probe = ultrasound::ProbeOfLook(*scene.probe, *DisplayOf(*scene.b_mode), 0);
  }
};

}  // namespace

const CoupledEffect& CtSlice() {
  static const CtSliceEffect effect;
  return effect;
}

const CoupledEffect& BMode() {
  static const BModeEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
