#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/aperture/aperture_rows.h"
#include "acus/imaging/ultrasound/aperture/aperture_tissue.h"
#include "acus/imaging/ultrasound/aperture/aperture_tracer.h"
#include "acus/imaging/ultrasound/beams/beam_input.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"
#include "acus/imaging/ultrasound/beams/beam_needle.h"
#include "acus/imaging/ultrasound/beams/refraction.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"
#include "acus/imaging/ultrasound/columns/echo_list.h"
#include "acus/imaging/ultrasound/display/beam_display.h"
#include "acus/imaging/ultrasound/display/compound_image.h"
#include "acus/imaging/ultrasound/speckle/clutter_haze.h"
#include "acus/imaging/ultrasound/speckle/place_hash.h"
#include "acus/imaging/ultrasound/speckle/speckle_lattice.h"

namespace acus::ultrasound {
namespace {

/// Rows of one piece of work.
constexpr int kRowsPerPieceOfImage = 32;
constexpr float kFaintestEcho = 1e-6F;
constexpr std::size_t kEchoesPerLine = 512;  ///< In each plane.
/// Reflections from which a surface is one of bone or gas.
constexpr float kStrong = 0.3F;
/// Numbers of the receiver's noise that are drawn once, and read from a random place for each row.
constexpr std::size_t kNoiseNumbers = std::size_t{1} << 16;
/// Amplitude of the fundamental that the receiver of the second harmonic lets through: -40 dB, as
/// two pulses of opposite sign cancel. Estimate.
constexpr float kNotFiltered = 0.01F;

int PiecesOf(int rows) {
  return (rows + kRowsPerPieceOfImage - 1) / kRowsPerPieceOfImage;
}

double OfDb(double db) {
  return std::pow(10.0, db / 20.0);
}

const ApertureOptions& Checked(const ApertureOptions& options) {
  const int planes = options.elevation_planes;
  ACUS_REQUIRE(planes >= 1 && planes <= 15 && planes % 2 == 1, "aperture: elevation_planes is ",
               planes, "; allowed is an odd number, 1 to 15");
  const int rays = options.aperture_rays;
  ACUS_REQUIRE(rays >= 1 && rays <= 31 && rays % 2 == 1, "aperture: aperture_rays is ", rays,
               "; allowed is an odd number, 1 to 31");
  ACUS_REQUIRE(options.point_spread_reach >= 1.0 && options.point_spread_reach <= 5.0,
               "aperture: point_spread_reach is ", options.point_spread_reach,
               "; allowed is 1 to 5");
  ACUS_REQUIRE(options.coupling_gap_mm >= 0.0 && options.coupling_gap_mm <= 100.0,
               "aperture: coupling_gap_mm is ", options.coupling_gap_mm, "; allowed is 0 to 100");
  ACUS_REQUIRE(!options.refraction || options.display.compound_angles == 1,
               "aperture: refraction with ", options.display.compound_angles,
               " compound angles: bent rays are not steered; set one of them to off (refraction "
               "false, or a display with compound_angles 1)");
  return options;
}

/// Haze comes from near the face, where there is little of the second harmonic.
double ClutterDb(const ApertureOptions& options) {
  const DisplayOptions& display = options.display;
  return options.clutter_db + (display.second_harmonic ? display.harmonic_clutter_db : 0.0);
}

ApertureOptions WithLeastReflection(ApertureOptions options) {
  // Smoothed boundaries have no noise, so that fainter ones than those of a CT are real.
  options.smallest_reflection = 0.002;
  return options;
}

/// A number that depends on all bits of a pose: the noise of the receiver is another one in every
/// image of a hand that is never quite still, and the same in a replay.
std::uint64_t HashOf(const Eigen::Isometry3d& pose) {
  std::uint64_t hash = 0x9E3779B97F4A7C15ULL;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(pose.matrix()(r, c))) * 0xBF58476D1CE4E5B9ULL;
      hash ^= hash >> 29;
    }
  }
  return hash;
}

/// In (-1, 1), the same for the same place in the tissue.
float PlaceNoise(const Eigen::Vector3f& index, int n) {
  const Eigen::Array3i at = (4.0F * index.array()).round().cast<int>();
  const std::uint32_t h =
      HashOfPlace(at[0], at[1], at[2], static_cast<std::uint32_t>(n) * 0x27D4EB2FU);
  return static_cast<float>(static_cast<std::int32_t>(h)) * (1.0F / 2147483648.0F);
}

}  // namespace

struct ApertureRenderer::State {
  State(const BeamTissue& tissue, const acoustics::Probe& checked_probe,
        const ApertureOptions& checked_options, std::shared_ptr<const ApertureTissue> given_tissue)
      : probe(checked_probe),
        options(WithLeastReflection(checked_options)),
        geometry(tissue.labels != nullptr ? tissue.labels->geometry : tissue.ct->geometry),
        grid(acoustics::BeamGridOf(probe)),
        samples_per_row(SamplesPerRow(grid, geometry)),
        rows(Coarser(grid, samples_per_row)),
        filter(probe, options, grid),
        shared(std::move(given_tissue)),
        volume(shared->volume),
        rays(probe, rows, options.aperture_rays),
        steered(probe.kind == acoustics::ProbeKind::kPhased && grid.lines() > 1
                    ? std::make_unique<SteeredRays>(probe, rows, options.aperture_rays)
                    : nullptr),
        field(rays, grid.lines(), rows.samples, steered.get()),
        tracer(
            volume, options, filter, rows, geometry.spacing_mm, samples_per_row,
            acoustics::WavelengthMm(probe) * probe.frequency_mhz / acoustics::ReceivedMhz(probe)),
        needle(probe, options, grid),
        samples_per_shown(SamplesPerShownRow(probe, grid)),
        shown_rows(ShownRows(grid, samples_per_shown)),
        display(probe, shown_rows, options.display, options.tgc_limit_db),
        haze(grid.lines(), kernels::RoundUp(grid.lines()), rows.step_mm, options.clutter_reach_mm,
             ClutterDb(options)) {
    MakePlanes();
    MakeNoise();
    if (options.refraction && grid.lines() > 1) {
      refraction = std::make_unique<Refraction>(
          SpeedVolume(tissue, BeamMaterials(tissue, options, probe, 1.0)), geometry, probe, rows,
          rays);
    }
    MakeSideLobes();
    echoes.re.Resize(grid.lines(), grid.samples);
    echoes.im.Resize(grid.lines(), grid.samples);
    intensity.Resize(grid.lines(), grid.samples);
    shown.Resize(grid.lines(), shown_rows.samples);
    speckle.Resize(grid.lines(), rows.samples);
    bright.Resize(grid.lines(), rows.samples);
    scratch_stride = 2 * static_cast<std::size_t>(echoes.re.stride());
    scratch.Reserve(scratch_stride * static_cast<std::size_t>(PiecesOf(grid.samples)));
    lanes = kernels::RoundUp(grid.lines());
    rough_layer = static_cast<float>(OfDb(options.rough_layer_db));
    rough_decay = static_cast<float>(
        options.rough_layer_mm > 0.0 ? std::exp(-grid.step_mm / options.rough_layer_mm) : 0.0);
    ones.Reserve(static_cast<std::size_t>(lanes));
    std::fill_n(ones.data(), lanes, 1.0F);
    lists.resize(static_cast<std::size_t>(tracer.blocks()));
    for (EchoList& list : lists) {
      list.Reserve(kEchoesPerLine * static_cast<std::size_t>(ApertureTracer::kLanesPerBlock) *
                   planes.size());
    }
  }

  void MakePlanes() {
    BeamPath::Frame frame;
    frame.grid = &rows;
    frame.index_from_ct = geometry.index_from_ct();
    // The plane in the middle first: contact is judged there, and the speckle is its own.
    frame.lattice_from_index = SpeckleLatticeFromIndex(geometry, filter.grain_mm(), options.seed);
    double sum = 0.0;
    for (int p = 0; p < options.elevation_planes; ++p) {
      const int from_middle = (p + 1) / 2 * (p % 2 == 1 ? -1 : 1);
      const double offset = 0.8 * from_middle;
      frame.elevation_mm.clear();
      for (int k = 0; k < rows.samples && offset != 0.0; ++k) {
        frame.elevation_mm.push_back(
            offset * acoustics::SigmaOfFwhm(acoustics::ElevationFwhmMm(probe, k * rows.step_mm)));
      }
      planes.push_back({.path = BeamPath(frame), .weight = std::exp(-0.5 * offset * offset)});
      frame.lattice_from_index.reset();
      sum += planes.back().weight;
    }
    for (AperturePlane& plane : planes) plane.weight /= sum;
  }

  void MakeSideLobes() {
    if (!options.side_lobes || grid.lines() < 2) return;
    lobes = std::make_unique<SideLobes>(probe, rows, options.apodisation, options.lobe_deg,
                                        options.diffuse_share);
    if (!lobes->any()) lobes.reset();
    strong.Resize(grid.lines(), rows.samples);
    // Each plane's echo has its weight; together they are one echo.
    double squares = 0.0;
    for (const AperturePlane& plane : planes) squares += plane.weight * plane.weight;
    per_planes = static_cast<float>(1.0 / squares);
  }

  void MakeNoise() {
    RandomStream random(options.seed, "noise of the receiver");
    noise.Reserve(kNoiseNumbers + 4096 + 64);
    for (std::size_t n = 0; n < kNoiseNumbers + 4096 + 64; ++n) {
      noise.data()[n] = static_cast<float>(random.Normal() / std::sqrt(2.0));
    }
  }

  /// What the needle takes from the sound behind it.
  void AddNeedleShadow(int block) {
    for (const NeedleMark* m = needle.begin(block); m != needle.end(block); ++m) {
      const int row = std::min(rows.samples - 1, m->sample / samples_per_row + 1);
      field.left(row)[m->line] *= std::sqrt(m->transmission);
    }
  }

  /// Fibres under the middle plane.
  void AddStreaks(int block) {
    const int first = block * ApertureTracer::kLanesPerBlock;
    const int count = std::min(ApertureTracer::kLanesPerBlock, grid.lines() - first);
    const BeamPath& path = planes.front().path;
    for (int k = 0; k < rows.samples; ++k) {
      shared->streaks->ApplyRow(path.Voxels(path.PieceAt(k), first), static_cast<float>(k), count,
                                tracer.scatter2(k) + first);
    }
  }

  void LoseFocus(int row) {
    alignas(64) std::array<float, 4096> gain;
    refraction->GainRow(row, gain.data());
    field.Scale(row, gain.data());
  }

  /// Amplitude that arrives at a place between rows.
  float ArrivingAt(float row, int line) const {
    const float at = std::clamp(row, 0.0F, static_cast<float>(rows.samples - 1));
    const int low = std::min(static_cast<int>(at), rows.samples - 2);
    const float a = field.arriving(low)[line];
    const float b = field.arriving(low + 1)[line];
    return a + (at - static_cast<float>(low)) * (b - a);
  }

  void AddSurface(const ApertureTracer::Crossing& at, EchoList& list) {
    // What arrives is judged before the slope of the boundary, some of whose loss lies before its
    // middle.
    const float arriving = ArrivingAt(at.row - at.lead, at.line);
    constexpr auto kMostGain = static_cast<float>(ApertureTracer::kMostObliqueGain);
    if (kMostGain * at.weight * std::abs(at.reflection) * arriving < kFaintestEcho) return;
    const ApertureTracer::SurfaceEcho echo = tracer.EchoOf(at);
    const float amplitude = echo.mirror * arriving;
    if (options.clutter) bright.row(static_cast<int>(at.row))[at.line] += amplitude * amplitude;
    if (lobes != nullptr) {
      strong.row(static_cast<int>(at.row))[at.line] += per_planes * amplitude * amplitude;
    }
    if (echo.rough * arriving < kFaintestEcho) return;
    const double sample = double{at.row} * samples_per_row;
    list.Add(filter, sample, at.line, amplitude);
    if (std::abs(at.reflection) < kStrong) return;
    // A rough surface answers over some depth.
    auto rough = echo.rough * arriving * rough_layer;
    const int most = static_cast<int>(3.0 * options.rough_layer_mm / grid.step_mm);
    const Eigen::Vector3f place =
        options.mean_speckle ? Eigen::Vector3f::Constant(static_cast<float>(at.line)) : at.index;
    for (int n = 1; n <= most && sample + n < grid.samples; ++n) {
      rough *= rough_decay;
      list.Add(filter, sample + n, at.line, rough * PlaceNoise(place, 2 * n),
               rough * PlaceNoise(place, 2 * n + 1));
    }
    // Gas reflects so well that sound goes to the face and back again.
    if (!options.comet_tail || at.reflection > -kStrong) return;
    auto again = std::abs(amplitude);
    for (int n = 2; n <= 5 && n * sample < grid.samples; ++n) {
      again *= static_cast<float>(options.face_reflection) * std::abs(amplitude);
      if (again < kFaintestEcho) break;
      list.Add(filter, n * sample, at.line, again);
    }
  }

  void AddNeedle(int block, EchoList& list) {
    for (const NeedleMark* m = needle.begin(block); m != needle.end(block); ++m) {
      const double sample = m->sample + double{m->beside};
      const float row = static_cast<float>(sample) / static_cast<float>(samples_per_row);
      float amplitude = m->echo * ArrivingAt(row, m->line);
      if (lobes != nullptr && row < static_cast<float>(rows.samples)) {
        strong.row(static_cast<int>(row))[m->line] += amplitude * amplitude;
      }
      for (int n = 0; n < 5 && amplitude > kFaintestEcho; ++n) {
        const double at = sample + n * needle.ring_samples();
        if (at >= grid.samples) break;
        list.Add(filter, at, m->line, amplitude);
        if (!options.comet_tail) break;
        amplitude *= static_cast<float>(options.needle_ring_decay);
      }
    }
  }

  /// Echoes of the probe itself: they fade within a few pulses; where the face looks into air they
  /// continue.
  void AddRingDown(int block, EchoList& list) const {
    const int first = block * ApertureTracer::kLanesPerBlock;
    const int end = std::min(grid.lines(), first + ApertureTracer::kLanesPerBlock);
    const double pulse_mm = acoustics::AxialFwhmMm(probe);
    for (int l = first; l < end; ++l) {
      const bool air = tracer.contact()[static_cast<std::size_t>(l)] == 0.0F;
      const double decay = air ? 0.6 : 0.35;
      const double spacing_mm = (air ? 3.0 : 1.2) * pulse_mm;
      double amplitude = OfDb(options.ring_down_db);
      // No two elements ring alike.
      amplitude *= 0.7 + 0.3 * PlaceNoise(Eigen::Vector3f::Constant(static_cast<float>(l)), 1);
      for (int n = 0; n < 24 && amplitude > kFaintestEcho; ++n, amplitude *= decay) {
        const double sample = n * spacing_mm / grid.step_mm;
        if (sample >= grid.samples) break;
        const float over =
            probe.second_harmonic ? kNotFiltered * OverHarmonic(n * spacing_mm) : 1.0F;
        list.Add(filter, sample, l, static_cast<float>(amplitude) * over);
      }
    }
  }

  /// What is no second harmonic, in units of the echoes, which are shown as if they were not
  /// weaker than those of the fundamental.
  float OverHarmonic(double depth_mm) const {
    return static_cast<float>(OfDb(-options.display.harmonic_db) /
                              acoustics::HarmonicBuildUp(probe, depth_mm));
  }

  void Clear(slicing::BeamImage& by_row, int block) const {
    const int first = block * ApertureTracer::kLanesPerBlock;
    const int count = std::min(ApertureTracer::kLanesPerBlock, lanes - first);
    for (int k = 0; k < rows.samples; ++k) std::fill_n(by_row.row(k) + first, count, 0.0F);
  }

  void CollectEchoes(int block) {
    EchoList& list = lists[static_cast<std::size_t>(block)];
    list.Clear();
    if (options.clutter) Clear(bright, block);
    if (lobes != nullptr) Clear(strong, block);
    // The list takes no more than it holds: first what must not be lost.
    AddNeedle(block, list);
    if (options.ring_down) AddRingDown(block, list);
    for (const ApertureTracer::Crossing& crossing : tracer.crossings(block)) {
      AddSurface(crossing, list);
    }
  }

  /// Amplitude of the speckle at each row of tissue, with the haze of the echoes around.
  void MakeSpeckleAmplitudes() {
    haze.Begin();
    for (int k = 0; k < rows.samples; ++k) {
      const float* arriving = field.arriving(k);
      const float* scatter2 = tracer.scatter2(k);
      float* out = speckle.row(k);
      if (!options.clutter) {
        for (int l = 0; l < lanes; ++l) out[l] = arriving[l] * std::sqrt(scatter2[l]);
        continue;
      }
      kernels::SquareRow(arriving, scatter2, lanes, out);
      haze.AddRow(bright.row(k), out);
    }
  }

  void AddSideLobes() {
    lobes->Spread(strong);
    for (int k = 0; k < rows.samples; ++k) {
      float* out = speckle.row(k);
      const float* added = lobes->added(k);
      for (int l = 0; l < grid.lines(); ++l) out[l] = std::sqrt(out[l] * out[l] + added[l]);
    }
  }

  void MakeSpeckleRow(int k, float* amplitude, float* after) {
    const int row = k / samples_per_row;
    const float place = static_cast<float>(k) / static_cast<float>(samples_per_row);
    kernels::LerpRow(speckle.row(row), speckle.row(row + 1), place - static_cast<float>(row), lanes,
                     amplitude);
    if (options.mean_speckle) {
      std::fill_n(echoes.re.row(k), lanes, 0.0F);
      std::fill_n(echoes.im.row(k), lanes, 0.0F);
      return;
    }
    const BeamPath& middle = planes.front().path;
    kernels::SpeckleRow row_of_speckle{.lattice = middle.Lattice(middle.PieceAt(row), 0),
                                       .scatter = ones.data(),
                                       .decay = ones.data(),
                                       .energy = amplitude,
                                       .energy_after = after,
                                       .gain = filter.SpeckleGain(k),
                                       .re = echoes.re.row(k),
                                       .im = echoes.im.row(k)};
    filter.look().Set(k, 0, row_of_speckle);
    kernels::SpeckleEchoRow(row_of_speckle, place, lanes, false);
  }

  void AddMeanSpeckle(int k) {
    const int row = k / samples_per_row;
    const float share =
        static_cast<float>(k - row * samples_per_row) / static_cast<float>(samples_per_row);
    const float* above = speckle.row(row);
    const float* below = speckle.row(row + 1);
    float* out = intensity.row(k);
    for (int l = 0; l < lanes; ++l) {
      const float amplitude = above[l] + share * (below[l] - above[l]);
      out[l] += amplitude * amplitude;
    }
  }

  void AddNoiseRow(int k, std::uint64_t pose_hash) {
    auto level = static_cast<float>(OfDb(options.noise_db)) * filter.NoiseGain(k);
    if (probe.second_harmonic) level *= OverHarmonic(k * grid.step_mm);
    std::uint64_t h = (pose_hash + static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15ULL;
    h ^= h >> 31;
    const float* re = noise.data() + (h & (kNoiseNumbers - 1));
    const float* im = noise.data() + (h >> 20 & (kNoiseNumbers - 1));
    kernels::AddScaledRow(re, level, lanes, echoes.re.row(k));
    kernels::AddScaledRow(im, level, lanes, echoes.im.row(k));
  }

  /// All that comes before the display.
  void TraceAndCompress(const Eigen::Isometry3d& ct_from_probe,
                        const std::optional<image::NeedleInImage>& needle_in_ct, int num_threads,
                        const slicing::RestMap* rest);

  void AverageShownRow(int r) {
    const int half = samples_per_shown / 2;
    const int middle = r * samples_per_shown;
    const int low = std::max(0, middle - half);
    const int high = std::min(grid.samples - 1, middle + half);
    float* out = shown.row(r);
    const float share = 1.0F / static_cast<float>(high - low + 1);
    std::fill_n(out, lanes, 0.0F);
    for (int k = low; k <= high; ++k) kernels::AddScaledRow(intensity.row(k), share, lanes, out);
  }

  acoustics::Probe probe;
  ApertureOptions options;
  volume::Geometry geometry;
  acoustics::ScanGrid grid;
  int samples_per_row;
  acoustics::ScanGrid rows;  ///< Of tissue, coarser than the samples.
  BeamFilter filter;
  std::shared_ptr<const ApertureTissue> shared;  ///< The same for all angles.
  const AcousticVolume& volume;
  ApertureRays rays;
  std::unique_ptr<SteeredRays> steered;  ///< Phased probes only.
  ApertureField field;
  ApertureTracer tracer;
  BeamNeedle needle;
  int samples_per_shown;
  acoustics::ScanGrid shown_rows;  ///< Of the image before scan conversion.
  BeamDisplay display;
  std::unique_ptr<Refraction> refraction;  ///< Null: straight rays.
  std::vector<AperturePlane> planes;
  std::vector<EchoList> lists;  ///< By block of lines.
  int lanes = 0;
  float rough_layer = 0.0F;  ///< Amplitude of its echoes, of the surface's.
  float rough_decay = 0.0F;  ///< From sample to sample.
  ComplexBeams echoes;
  slicing::BeamImage speckle;        ///< Amplitude, by row of tissue.
  std::unique_ptr<SideLobes> lobes;  ///< Null: none, or none that is visible.
  slicing::BeamImage strong;         ///< Intensity that lobes spread, by row of tissue.
  float per_planes = 1.0F;
  slicing::BeamImage bright;  ///< Intensity of interfaces, by row of tissue.
  slicing::BeamImage intensity;
  slicing::BeamImage shown;  ///< Intensity, by row of the shown image.
  slicing::BeamImage envelope;
  image::AlignedFloats ones;
  image::AlignedFloats noise;
  image::AlignedFloats scratch;
  std::size_t scratch_stride = 0;
  ClutterHaze haze;
  std::vector<std::unique_ptr<State>> angles;  ///< The other angles of a compound image.
  std::optional<CompoundImage> compound;
};

void ApertureRenderer::State::TraceAndCompress(
    const Eigen::Isometry3d& ct_from_probe, const std::optional<image::NeedleInImage>& needle_in_ct,
    int num_threads, const slicing::RestMap* rest) {
  needle.Set(needle_in_ct, ct_from_probe, ApertureTracer::kLanesPerBlock);
  if (refraction != nullptr) {
    refraction->Trace(ct_from_probe, rest, num_threads);
    rest = refraction.get();
  }
  for (AperturePlane& plane : planes) plane.path.Set(ct_from_probe, rest);
  const std::uint64_t pose_hash =
      HashOf(ct_from_probe) ^ std::bit_cast<std::uint64_t>(probe.steer_rad);
  ParallelFor(tracer.blocks(), num_threads, [this](int block) {
    tracer.TraceBlock(planes, block, field);
    if (shared->streaks) AddStreaks(block);
    AddNeedleShadow(block);
  });
  field.March(tracer.SmoothContact(), num_threads);
  for (int k = 0; refraction != nullptr && k < rows.samples; ++k) LoseFocus(k);
  ParallelFor(tracer.blocks(), num_threads, [this](int block) { CollectEchoes(block); });
  MakeSpeckleAmplitudes();
  if (lobes != nullptr) AddSideLobes();
  ParallelFor(PiecesOf(grid.samples), num_threads, [this, pose_hash](int piece) {
    const int first = piece * kRowsPerPieceOfImage;
    const int last = std::min(grid.samples, first + kRowsPerPieceOfImage);
    float* amplitude = scratch.data() + static_cast<std::size_t>(piece) * scratch_stride;
    for (int k = first; k < last; ++k) {
      MakeSpeckleRow(k, amplitude, amplitude + lanes);
      if (options.noise) AddNoiseRow(k, pose_hash);
    }
  });
  ParallelFor(tracer.blocks(), num_threads, [this](int block) {
    lists[static_cast<std::size_t>(block)].PutInto(filter, echoes);
  });
  ParallelFor(PiecesOf(grid.samples), num_threads, [this](int piece) {
    const int first = piece * kRowsPerPieceOfImage;
    const int last = std::min(grid.samples, first + kRowsPerPieceOfImage);
    filter.Apply(echoes, first, last,
                 scratch.data() + static_cast<std::size_t>(piece) * scratch_stride, intensity);
    for (int k = first; options.mean_speckle && k < last; ++k) AddMeanSpeckle(k);
  });
  ParallelFor(PiecesOf(shown_rows.samples), num_threads, [this](int piece) {
    const int first = piece * kRowsPerPieceOfImage;
    const int last = std::min(shown_rows.samples, first + kRowsPerPieceOfImage);
    for (int r = first; r < last; ++r) AverageShownRow(r);
    display.Compress(shown, first, last);
  });
}

ApertureRenderer::ApertureRenderer(const BeamTissue& tissue, const acoustics::Probe& probe,
                                   const ApertureOptions& options, int num_threads,
                                   ApertureTissueStore* store) {
  const BeamTissue& checked = CheckedBeamTissue(tissue, "aperture");
  const acoustics::Probe middle = ProbeOfLook(CheckedBeamProbe(probe), options.display, 0);
  Checked(options);
  ApertureTissueStore own;
  const auto shared = (store != nullptr ? *store : own).Get(checked, middle, options, num_threads);
  state_ = std::make_unique<State>(checked, middle, options, shared);
  std::vector<BeamDisplay*> displays = {&state_->display};
  for (int look = 1; look < options.display.compound_angles; ++look) {
    state_->angles.push_back(std::make_unique<State>(
        checked, ProbeOfLook(probe, options.display, look), options, shared));
    displays.push_back(&state_->angles.back()->display);
  }
  if (displays.size() > 1) state_->compound.emplace(std::move(displays));
}
ApertureRenderer::~ApertureRenderer() = default;
ApertureRenderer::ApertureRenderer(ApertureRenderer&&) noexcept = default;
ApertureRenderer& ApertureRenderer::operator=(ApertureRenderer&&) noexcept = default;

void ApertureRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                              const std::optional<image::NeedleInImage>& needle,
                              image::GrayImage& out, int num_threads,
                              const slicing::RestMap* rest) {
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

const slicing::BeamImage& ApertureRenderer::envelope() {
  State& s = *state_;
  s.envelope.Resize(s.grid.lines(), s.grid.samples);
  for (int k = 0; k < s.grid.samples; ++k) {
    for (int l = 0; l < s.grid.lines(); ++l) {
      s.envelope.row(k)[l] = std::sqrt(s.intensity.row(k)[l]);
    }
  }
  return s.envelope;
}

const acoustics::ScanGrid& ApertureRenderer::grid() const {
  return state_->grid;
}
const image::ImageGeometry& ApertureRenderer::image() const {
  return state_->display.image();
}
std::size_t ApertureRenderer::volume_bytes() const {
  return state_->volume.bytes();
}

}  // namespace acus::ultrasound
