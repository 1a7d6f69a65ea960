#include "acus/imaging/ultrasound/beams/beam_renderer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_filter.h"
#include "acus/imaging/ultrasound/beams/beam_input.h"
#include "acus/imaging/ultrasound/beams/beam_materials.h"
#include "acus/imaging/ultrasound/beams/beam_needle.h"
#include "acus/imaging/ultrasound/beams/beam_path.h"
#include "acus/imaging/ultrasound/beams/beam_tracer.h"
#include "acus/imaging/ultrasound/display/beam_display.h"
#include "acus/imaging/ultrasound/display/compound_image.h"
#include "acus/imaging/ultrasound/speckle/speckle_lattice.h"

namespace acus::ultrasound {
namespace {

/// Rows of one piece of work.
constexpr int kRowsPerTask = 32;

int Pieces(int rows) {
  return (rows + kRowsPerTask - 1) / kRowsPerTask;
}

const BeamOptions& Checked(const BeamOptions& options) {
  const int planes = options.elevation_planes;
  ACUS_REQUIRE(planes >= 1 && planes <= 15 && planes % 2 == 1, "beams: elevation_planes is ",
               planes, "; allowed is an odd number, 1 to 15");
  ACUS_REQUIRE(options.point_spread_reach >= 1.0 && options.point_spread_reach <= 5.0,
               "beams: point_spread_reach is ", options.point_spread_reach, "; allowed is 1 to 5");
  ACUS_REQUIRE(options.smallest_reflection > 0.0 && options.smallest_reflection < 1.0,
               "beams: smallest_reflection is ", options.smallest_reflection,
               "; allowed is above 0 to below 1");
  ACUS_REQUIRE(options.coupling_gap_mm >= 0.0 && options.coupling_gap_mm <= 100.0,
               "beams: coupling_gap_mm is ", options.coupling_gap_mm, "; allowed is 0 to 100");
  return options;
}

/// Gaussian weights of planes at multiples of 0.8 standard deviations.
double PlaneOffset(int plane, int planes) {
  return planes == 1 ? 0.0 : 0.8 * (plane - planes / 2);
}

}  // namespace

struct BeamRenderer::State {
  State(const BeamTissue& given, const acoustics::Probe& checked_probe,
        const BeamOptions& checked_options)
      : tissue(given),
        probe(checked_probe),
        options(checked_options),
        grid(acoustics::BeamGridOf(probe)),
        materials(tissue, options, probe, grid.step_mm),
        filter(probe, options, grid),
        lattice_from_index(SpeckleLatticeFromIndex(geometry(), filter.grain_mm(), options.seed)),
        tracer(tissue, options, materials, filter, grid, lattice_from_index),
        needle(probe, options, grid),
        display(probe, grid, options.display) {
    MakePlanes();
    echoes.re.Resize(grid.lines(), grid.samples);
    echoes.im.Resize(grid.lines(), grid.samples);
    intensity.Resize(grid.lines(), grid.samples);
    scratch_stride = 2 * static_cast<std::size_t>(echoes.re.stride());
    scratch.Reserve(scratch_stride * static_cast<std::size_t>(Pieces(grid.samples)));
  }

  const volume::Geometry& geometry() const {
    return tissue.labels != nullptr ? tissue.labels->geometry : tissue.ct->geometry;
  }

  void MakePlanes() {
    BeamPath::Frame frame;
    frame.grid = &grid;
    frame.index_from_ct = geometry().index_from_ct();
    frame.lattice_from_index = lattice_from_index;
    materials.TurnFibres(lattice_from_index * geometry().index_from_ct().linear(),
                         filter.grain_mm());
    double sum = 0.0;
    for (int p = 0; p < options.elevation_planes; ++p) {
      const double offset = PlaneOffset(p, options.elevation_planes);
      frame.elevation_mm.clear();
      if (offset != 0.0) {
        for (int k = 0; k < grid.samples; ++k) {
          frame.elevation_mm.push_back(
              offset * acoustics::SigmaOfFwhm(acoustics::ElevationFwhmMm(probe, k * grid.step_mm)));
        }
      }
      planes.push_back({.path = BeamPath(frame), .weight = std::exp(-0.5 * offset * offset)});
      sum += planes.back().weight;
    }
    double squares = 0.0;
    for (ElevationPlane& plane : planes) {
      plane.weight /= sum;
      squares += plane.weight * plane.weight;
    }
    // Interfaces of all planes add up in phase, their speckle does not.
    for (ElevationPlane& plane : planes) plane.speckle_weight = plane.weight / std::sqrt(squares);
  }

  void TraceAndCompress(const Eigen::Isometry3d& ct_from_probe,
                        const std::optional<image::NeedleInImage>& needle_in_ct, int num_threads,
                        const slicing::RestMap* rest);

  BeamTissue tissue;
  acoustics::Probe probe;
  BeamOptions options;
  acoustics::ScanGrid grid;
  BeamMaterials materials;
  BeamFilter filter;
  Eigen::Matrix3d lattice_from_index;
  BeamTracer tracer;
  BeamNeedle needle;
  BeamDisplay display;
  std::vector<ElevationPlane> planes;
  ComplexBeams echoes;
  slicing::BeamImage intensity;
  slicing::BeamImage envelope;
  image::AlignedFloats scratch;
  std::size_t scratch_stride = 0;
  std::vector<std::unique_ptr<State>> angles;  ///< The other angles of a compound image.
  std::optional<CompoundImage> compound;
};

void BeamRenderer::State::TraceAndCompress(const Eigen::Isometry3d& ct_from_probe,
                                           const std::optional<image::NeedleInImage>& needle_in_ct,
                                           int num_threads, const slicing::RestMap* rest) {
  needle.Set(needle_in_ct, ct_from_probe, BeamTracer::kLanesPerBlock);
  for (ElevationPlane& plane : planes) plane.path.Set(ct_from_probe, rest);
  ParallelFor(tracer.blocks(), num_threads,
              [this](int block) { tracer.TraceBlock(planes, needle, block, echoes); });
  ParallelFor(Pieces(grid.samples), num_threads, [this](int piece) {
    const int first = piece * kRowsPerTask;
    const int last = std::min(grid.samples, first + kRowsPerTask);
    filter.Apply(echoes, first, last,
                 scratch.data() + static_cast<std::size_t>(piece) * scratch_stride, intensity);
    display.Compress(intensity, first, last);
  });
}

BeamRenderer::BeamRenderer(const BeamTissue& tissue, const acoustics::Probe& probe,
                           const BeamOptions& options)
    : state_(std::make_unique<State>(CheckedBeamTissue(tissue, "beams"),
                                     ProbeOfLook(CheckedBeamProbe(probe), options.display, 0),
                                     Checked(options))) {
  State& s = *state_;
  std::vector<BeamDisplay*> displays = {&s.display};
  for (int look = 1; look < options.display.compound_angles; ++look) {
    s.angles.push_back(
        std::make_unique<State>(tissue, ProbeOfLook(probe, options.display, look), options));
    s.angles.back()->tissue.acoustics = nullptr;
    displays.push_back(&s.angles.back()->display);
  }
  if (displays.size() > 1) s.compound.emplace(std::move(displays));
  s.tissue.acoustics = nullptr;  // It has been read.
}
BeamRenderer::~BeamRenderer() = default;
BeamRenderer::BeamRenderer(BeamRenderer&&) noexcept = default;
BeamRenderer& BeamRenderer::operator=(BeamRenderer&&) noexcept = default;

void BeamRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                          const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
                          int num_threads, const slicing::RestMap* rest) {
  State& s = *state_;
  ACUS_REQUIRE(ct_from_probe.matrix().allFinite(), "probe pose: has a value that is not finite");
  s.TraceAndCompress(ct_from_probe, needle, num_threads, rest);
  for (auto& look : s.angles) look->TraceAndCompress(ct_from_probe, needle, num_threads, rest);
  if (s.compound) {
    s.compound->Show(out, num_threads);
  } else {
    s.display.Show(out, num_threads);
  }
}

const slicing::BeamImage& BeamRenderer::envelope() {
  State& s = *state_;
  s.envelope.Resize(s.grid.lines(), s.grid.samples);
  for (int k = 0; k < s.grid.samples; ++k) {
    for (int l = 0; l < s.grid.lines(); ++l) {
      s.envelope.row(k)[l] = std::sqrt(s.intensity.row(k)[l]);
    }
  }
  return s.envelope;
}

const acoustics::ScanGrid& BeamRenderer::grid() const {
  return state_->grid;
}
const image::ImageGeometry& BeamRenderer::image() const {
  return state_->display.image();
}
const acoustics::Probe& BeamRenderer::probe() const {
  return state_->probe;
}
const BeamOptions& BeamRenderer::options() const {
  return state_->options;
}

}  // namespace acus::ultrasound
