#include "ultrasound/bmode.h"

#include <cmath>

#include "core/error.h"
#include "ultrasound/ct_sampler.h"
#include "ultrasound/display.h"
#include "ultrasound/echo.h"
#include "ultrasound/needle_paint.h"

namespace acus::ultrasound {
namespace {

/// Probes are also made in code, past the schema: here is what the stages rely on.
const Probe& Checked(const Probe& probe) {
  constexpr int kMinPx = 16;
  constexpr int kMaxPx = 4096;
  ACUS_REQUIRE(probe.image_width_px >= kMinPx && probe.image_width_px <= kMaxPx &&
                   probe.image_height_px >= kMinPx && probe.image_height_px <= kMaxPx,
               "probe: picture of ", probe.image_width_px, " x ", probe.image_height_px,
               " pixels; allowed is ", kMinPx, " to ", kMaxPx, " each way");
  ACUS_REQUIRE(probe.depth_mm > 0.0 && std::isfinite(probe.depth_mm), "probe: depth ",
               probe.depth_mm, " mm; it must be above 0");
  if (probe.kind == ProbeKind::kLinear) {
    ACUS_REQUIRE(probe.width_mm > 0.0 && std::isfinite(probe.width_mm), "probe: width ",
                 probe.width_mm, " mm; it must be above 0");
  } else {
    ACUS_REQUIRE(probe.radius_mm > 0.0 && std::isfinite(probe.radius_mm) &&
                     probe.field_of_view_rad > 0.0 && probe.field_of_view_rad < 3.0 &&
                     probe.scan_lines >= kMinPx && probe.scan_lines <= kMaxPx,
                 "probe: radius ", probe.radius_mm, " mm, field of view ", probe.field_of_view_rad,
                 " rad, ", probe.scan_lines, " lines; allowed is above 0, 0 to 3, ", kMinPx, " to ",
                 kMaxPx);
  }
  ACUS_REQUIRE(probe.dynamic_range_db > 0.0 && probe.dynamic_range_db <= 120.0,
               "probe: dynamic range ", probe.dynamic_range_db, " dB; allowed is above 0 to 120");
  ACUS_REQUIRE(std::isfinite(probe.gain_db) && std::isfinite(probe.tgc_db_per_cm),
               "probe: its gain is not finite");
  ACUS_REQUIRE(
      probe.slice_thickness_mm >= 0.0 && probe.pulse_length_mm >= 0.0 && probe.beam_width_mm >= 0.0,
      "probe: slice thickness ", probe.slice_thickness_mm, " mm, pulse length ",
      probe.pulse_length_mm, " mm, beam width ", probe.beam_width_mm, " mm; none may be negative");
  return probe;
}

}  // namespace

struct BModeRenderer::State {
  State(const volume::CtVolume& ct, const Probe& checked_probe, const BModeOptions& options)
      : probe(checked_probe),
        picture(PictureOf(probe)),
        grid(ScanGridOf(probe)),
        sampler(ct),
        tracer(grid, probe.frequency_mhz, options, ct.geometry),
        display(probe, grid) {}

  Probe probe;
  ImageGeometry picture;
  ScanGrid grid;
  CtSampler sampler;
  EchoTracer tracer;
  EchoDisplay display;
  BeamLines lines;
  BeamBend bend;
  BeamImage hu;
  BeamImage echo;
};

BModeRenderer::BModeRenderer(const volume::CtVolume& ct, const Probe& probe,
                             const BModeOptions& options)
    : state_(std::make_unique<State>(ct, Checked(probe), options)) {}
BModeRenderer::~BModeRenderer() = default;
BModeRenderer::BModeRenderer(BModeRenderer&&) noexcept = default;
BModeRenderer& BModeRenderer::operator=(BModeRenderer&&) noexcept = default;

void BModeRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                           const std::optional<NeedleInImage>& needle, GrayImage& out,
                           int num_threads, const RestMap* rest) {
  State& s = *state_;
  s.sampler.PlaceLines(s.grid, ct_from_probe, s.lines);
  s.bend.Set(s.grid, ct_from_probe, s.sampler.index_from_ct(), rest);
  s.hu.Resize(s.grid.lines(), s.grid.samples);
  s.sampler.Sample(s.lines, s.bend, s.hu, num_threads);
  if (needle) PaintNeedle(*needle, ct_from_probe, s.probe.slice_thickness_mm, s.grid, s.hu);
  s.tracer.Trace(s.lines, s.bend, s.hu, s.echo, num_threads);
  s.display.Show(s.echo, out, num_threads);
}

const ImageGeometry& BModeRenderer::picture() const {
  return state_->picture;
}
const Probe& BModeRenderer::probe() const {
  return state_->probe;
}

}  // namespace acus::ultrasound
