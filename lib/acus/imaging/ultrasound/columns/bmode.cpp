#include "acus/imaging/ultrasound/columns/bmode.h"

#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/needle_paint.h"
#include "acus/imaging/ultrasound/beams/scan_end.h"
#include "acus/imaging/ultrasound/columns/echo.h"
#include "acus/imaging/ultrasound/display/display.h"

namespace acus::ultrasound {
struct BModeRenderer::State {
  State(const volume::CtVolume& ct, const acoustics::Probe& checked_probe,
        const BModeOptions& options)
      : probe(checked_probe),
        image(acoustics::ImageOf(probe)),
        grid(acoustics::ScanGridOf(probe)),
        sampler(ct),
        tracer(grid, probe.frequency_mhz, options, ct.geometry),
        display(probe, grid) {}

  acoustics::Probe probe;
  image::ImageGeometry image;
  acoustics::ScanGrid grid;
  slicing::CtSampler sampler;
  EchoTracer tracer;
  EchoDisplay display;
  slicing::BeamLines lines;
  slicing::BeamBend bend;
  slicing::BeamImage hu;
  slicing::BeamImage echo;
  ScanEnds scan_ends;
};

BModeRenderer::BModeRenderer(const volume::CtVolume& ct, const acoustics::Probe& probe,
                             const BModeOptions& options)
    : state_(std::make_unique<State>(ct, acoustics::CheckedProbe(probe), options)) {}
BModeRenderer::~BModeRenderer() = default;
BModeRenderer::BModeRenderer(BModeRenderer&&) noexcept = default;
BModeRenderer& BModeRenderer::operator=(BModeRenderer&&) noexcept = default;

void BModeRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                           const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
                           int num_threads, const slicing::RestMap* rest) {
  State& s = *state_;
  s.sampler.PlaceLines(s.grid, ct_from_probe, s.lines);
  s.bend.Set(s.grid, ct_from_probe, s.sampler.index_from_ct(), rest);
  s.hu.Resize(s.grid.lines(), s.grid.samples);
  s.sampler.Sample(s.lines, s.bend, s.hu, num_threads, slicing::CtSampler::kNotScanned);
  s.scan_ends.FindAndFill(s.hu);
  if (needle)
    slicing::PaintNeedle(*needle, ct_from_probe, s.probe.slice_thickness_mm, s.grid, s.hu);
  s.tracer.Trace(s.lines, s.bend, s.hu, s.echo, num_threads);
  for (int k = s.scan_ends.earliest(); k < s.echo.samples(); ++k) {
    s.scan_ends.Clear(k, s.echo.row(k));
  }
  s.display.Show(s.echo, out, num_threads);
}

const image::ImageGeometry& BModeRenderer::image() const {
  return state_->image;
}
const acoustics::Probe& BModeRenderer::probe() const {
  return state_->probe;
}

}  // namespace acus::ultrasound
