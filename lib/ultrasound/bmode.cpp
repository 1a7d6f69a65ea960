#include "ultrasound/bmode.h"

#include "ultrasound/ct_sampler.h"
#include "ultrasound/display.h"
#include "ultrasound/echo.h"
#include "ultrasound/needle_paint.h"

namespace acus::ultrasound {
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
    : state_(std::make_unique<State>(ct, CheckedProbe(probe), options)) {}
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
