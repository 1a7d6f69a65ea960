#include "acus/patient/breathing_registration/capture_inputs.h"

#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/patient_tissue.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace acus::breathing_registration {
namespace {

namespace fs = std::filesystem;

Capture FromImages(const CaptureInputs& inputs, const PhaseFiles& files,
                   const CaptureSettings& settings, RunContext& context) {
  fs::path landmarks = inputs.landmarks;
  if (landmarks.empty() && fs::exists(inputs.phases / "landmarks.csv")) {
    landmarks = inputs.phases / "landmarks.csv";
  }
  // Before the long work, so that a broken table is said at once.
  const KnownLandmarks known = landmarks.empty() ? KnownLandmarks{} : ReadKnownLandmarks(landmarks);
  const auto reference = ReadPhase(files.phases[ReferenceOf(files)], context);
  const Tissue tissue = TissueOf(reference, inputs.labels, inputs.sliding, context);
  return CaptureMotion(files, reference, tissue, known, settings, context);
}

Capture FromFields(const CaptureInputs& inputs, const PhaseFiles& files,
                   const CaptureSettings& settings, const RunContext& context) {
  if (inputs.ct.empty()) return CaptureFields(files, nullptr, settings, context);
  const auto ct = volume::ReadCt(inputs.ct, "", context);
  return CaptureFields(files, &ct.geometry, settings, context);
}

}  // namespace

Capture CaptureFrom(const CaptureInputs& inputs, const CaptureSettings& settings,
                    RunContext& context) {
  std::optional<breathing::BreathSignal> signal;
  std::optional<double> period_s;
  if (!inputs.signal.empty()) {
    signal = breathing::ReadBreathSignal(inputs.signal, {.column = inputs.column});
    period_s = breathing::RecordedBreath(*signal, {}).period_s();
  }
  Capture capture = [&] {
    if (!inputs.single.empty()) {
      const auto ct = volume::ReadCt(inputs.single, "", context);
      return CaptureSingle(segmentation::TissuesOf(ct, inputs.labels, context), inputs.diaphragm_mm,
                           settings, context);
    }
    if (!inputs.fields.empty()) {
      return FromFields(inputs, FindPhases(inputs.fields, signal), settings, context);
    }
    PhaseFiles phases = FindPhases(inputs.phases, signal);
    if (!phases.omitted.empty()) {
      context.Warn(Message(inputs.phases.string(),
                           ": series without the number of a phase omitted: ", phases.omitted));
    }
    return FromImages(inputs, std::move(phases), settings, context);
  }();
  capture.motion.period_s = period_s.value_or(capture.motion.period_s);
  return capture;
}

}  // namespace acus::breathing_registration
