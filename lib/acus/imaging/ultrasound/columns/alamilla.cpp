#include "acus/imaging/ultrasound/columns/alamilla.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/slicing/needle_paint.h"
#include "acus/imaging/ultrasound/display/display.h"
#include "acus/imaging/ultrasound/speckle/blur_kernel.h"
#include "acus/imaging/ultrasound/speckle/place_hash.h"

namespace acus::ultrasound {
namespace {

constexpr int kNeedle = 256;
constexpr int kRowsPerPiece = 32;
constexpr int kLinesPerPiece = 32;
constexpr int kVoxelsPerGrain = 4;
constexpr double kSlopeReachMm = 2.0;  ///< Slopes of surfaces are taken over this, to each side.

void Check(const AlamillaOptions& o) {
  ACUS_REQUIRE(o.surface_mm > 0.0, "surface_mm: is ", o.surface_mm, "; it must be above 0");
  ACUS_REQUIRE(o.shadow_share >= 0.0 && o.shadow_share <= 1.0, "shadow_share: is ", o.shadow_share,
               "; allowed is 0 to 1");
  ACUS_REQUIRE(o.thick_fibre_ratio >= 1.0 && o.thin_fibre_mm >= 0.0, "fibres: ratio ",
               o.thick_fibre_ratio, ", length ", o.thin_fibre_mm,
               " mm; allowed is from 1 and from 0");
  for (const AlamillaTissue& t : o.tissues) {
    ACUS_REQUIRE(t.grain_mm > 0.0, "tissue ", t.tissue, ": grain of ", t.grain_mm,
                 " mm; it must be above 0");
  }
}

}  // namespace

AlamillaRenderer::AlamillaRenderer(const volume::LabelMap& labels, const acoustics::Probe& probe,
                                   const AlamillaOptions& options,
                                   const tracing::SurfaceTracer* triangles)
    : labels_(labels),
      probe_(acoustics::CheckedProbe(probe)),
      options_(options),
      grid_(acoustics::ScanGridOf(probe_)),
      conversion_(probe_, grid_),
      index_from_ct_(labels.geometry.index_from_ct()),
      brightness_(BrightnessOfGain(probe_, options.gain_of_table_db)) {
  Check(options);
  ACUS_REQUIRE(
      (labels.geometry.size > 0).all() && labels.voxels.size() == labels.geometry.num_voxels(),
      "label map: ", labels.voxels.size(), " voxels do not fill its size");
  if (triangles != nullptr) traced_.emplace(*triangles, labels.geometry.ct_from_index());
  FillTissues(triangles);
}

void AlamillaRenderer::FillTissues(const tracing::SurfaceTracer* triangles) {
  std::bitset<256> occurs;
  for (const volume::Label label : labels_.voxels) occurs.set(label);
  // Between the centres of voxels there may be tissue that no voxel has.
  for (std::size_t n = 0; triangles != nullptr && n < triangles->num_surfaces(); ++n) {
    occurs.set(triangles->label(n));
  }
  std::array<const AlamillaTissue*, 256> row{};
  std::bitset<256> fibrous;
  for (const auto& [label, name] : labels_.names) {
    const auto found = std::ranges::find(options_.tissues, name, &AlamillaTissue::tissue);
    if (label == 0 || !occurs[label]) continue;
    ACUS_REQUIRE(found != options_.tissues.end(), options_.file, ": has no row for ", name,
                 " (label ", int{label}, "), which occurs in the label map; add one");
    row[label] = &*found;
    fibrous[label] = options_.fibres && found->texture != TissueTexture::kSpeckle;
  }
  if (options_.speckle) {
    noise_tile_ = NoiseTile::Perlin(kVoxelsPerGrain, 1, "speckle", options_.seed);
    if (fibrous.any()) fibres_.emplace(labels_, fibrous);
  }
  const Eigen::Affine3d ct_from_index = labels_.geometry.ct_from_index();
  for (std::size_t l = 1; l < 256; ++l) {
    if (!occurs[l]) continue;
    ACUS_REQUIRE(row[l] != nullptr, "label map: label ", l, " occurs but has no name");
    const AlamillaTissue& t = *row[l];
    TissueRow& out = tissue_[l];
    out.grey = static_cast<float>(t.grey);
    out.contrast = static_cast<float>(t.contrast);
    out.passed = static_cast<float>(
        options_.absorption ? std::exp(-t.absorption_per_cm * 0.1 * grid_.step_mm) : 1.0);
    out.reflection = static_cast<float>(t.reflection);
    out.blocks = t.blocks;
    out.thin_fibres = fibres_ && fibrous[l] && t.texture == TissueTexture::kThinFibres;
    Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
    if (fibres_ && fibrous[l] && t.texture == TissueTexture::kThickFibres) {
      const Eigen::Vector3d f =
          fibres_->MainDirection(static_cast<volume::Label>(l)).cast<double>();
      stretch -= (1.0 - 1.0 / options_.thick_fibre_ratio) * f * f.transpose();
    }
    Eigen::Matrix3d tile = kVoxelsPerGrain / t.grain_mm * stretch * ct_from_index.linear();
    if (options_.speckle && t.example) {
      tile = AddExample(t, static_cast<volume::Label>(l), fibres_ && fibrous[l]) *
             ct_from_index.linear();
      out.example = static_cast<int>(examples_.size()) - 1;
      out.contrast = 1.0F;
    }
    for (int a = 0; a < 9; ++a) {
      out.tile_from_index[static_cast<std::size_t>(a)] = static_cast<float>(tile(a / 3, a % 3));
    }
  }
  tissue_[kNeedle] = {.grey = 0.9F, .reflection = 1.0F};
}

/// Reads the images of a tissue. @return places of the texture, mm, from those of the CT: along the
/// fibres, and twice across them.
Eigen::Matrix3d AlamillaRenderer::AddExample(const AlamillaTissue& tissue, volume::Label label,
                                             bool fibrous) {
  const TextureImages& images = *tissue.example;
  std::optional<TextureExample> across;
  if (!images.across.empty()) across = TextureExample::Read(images.across, images.mm_per_px);
  Eigen::Vector3d fibre = Eigen::Vector3d::UnitX();
  if (fibrous) {
    const Eigen::Vector3d main = fibres_->MainDirection(label).cast<double>();
    if (main.norm() > 0.5) fibre = main.normalized();
  }
  examples_.push_back(
      {ExampleTexture(TextureExample::Read(images.along, images.mm_per_px), across,
                      HashOfPlace(label, 0, 0, static_cast<std::uint32_t>(options_.seed))),
       fibre});
  Eigen::Matrix3d frame;
  frame.row(0) = fibre;
  frame.row(1) = fibre.unitOrthogonal();
  frame.row(2) = frame.row(0).cross(frame.row(1));
  return frame;
}

/// Which of a tissue's two images counts by how much, for the plane of this image.
void AlamillaRenderer::TurnExamples(const Eigen::Vector3d& image_normal_in_ct) {
  for (ExampleRow& row : examples_) {
    const double along_normal = row.fibre.dot(image_normal_in_ct);
    row.share_across = row.texture.has_across()
                           ? static_cast<float>(std::min(1.0, along_normal * along_normal))
                           : 0.0F;
    row.per_mean = 0.5F / row.texture.Mean(row.share_across);
  }
}

volume::Label AlamillaRenderer::LabelAt(const float* index) const {
  const Eigen::Array3i& size = labels_.geometry.size;
  int at[3];
  for (int a = 0; a < 3; ++a) {
    if (!(index[a] > -0.5F && index[a] < static_cast<float>(size[a]) - 0.5F)) return 0;
    at[a] = static_cast<int>(index[a] + 0.5F);
  }
  return labels_.At(at[0], at[1], at[2]);
}

void AlamillaRenderer::SampleRow(int k) {
  const int lanes = slicing::kernels::RoundUp(label_.lines());
  for (int first = 0; first < lanes; first += slicing::BeamBend::kMaxLanes) {
    const int count = std::min(slicing::BeamBend::kMaxLanes, lanes - first);
    slicing::BeamBend::Row row;
    float sample = 0.0F;
    const slicing::kernels::Lines placed = bend_.PlaceRow(lines_, k, first, count, row, sample);
    alignas(64) float place[3][slicing::BeamBend::kMaxLanes];
    alignas(64) static constexpr std::array<float, slicing::BeamBend::kMaxLanes> kNoStep{};
    float* label = label_.row(k) + first;
    for (int l = 0; l < count; ++l) {
      float index[3];
      for (int a = 0; a < 3; ++a) index[a] = placed.start[a][l] + sample * placed.step[a][l];
      if (!traced_) label[l] = static_cast<float>(LabelAt(index));
      const auto value = static_cast<std::size_t>(label[l]);
      const auto& tile = tissue_[value].tile_from_index;
      for (std::size_t a = 0; a < 3; ++a) {
        place[a][l] =
            tile[3 * a] * index[0] + tile[3 * a + 1] * index[1] + tile[3 * a + 2] * index[2];
      }
    }
    if (!noise_tile_) continue;
    slicing::kernels::Lines tile_lines{};
    for (int a = 0; a < 3; ++a) {
      tile_lines.start[a] = place[a];
      tile_lines.step[a] = kNoStep.data();
    }
    const float one[3] = {1.0F, 1.0F, 1.0F};
    noise_tile_->Row(tile_lines, 0.0F, one, count, noise_.row(k) + first);
    if (examples_.empty()) continue;
    for (int l = 0; l < count; ++l) {
      const int example = tissue_[static_cast<std::size_t>(label[l])].example;
      if (example < 0) continue;
      const ExampleRow& of = examples_[static_cast<std::size_t>(example)];
      // With a contrast of 1 the grey is the row's times the texture's over its mean.
      noise_.row(k)[first + l] =
          of.per_mean * of.texture.GreyAt({place[0][l], place[1][l], place[2][l]}, of.share_across);
    }
  }
}

void AlamillaRenderer::FillCoupling() {
  const int gap = static_cast<int>(std::floor(options_.coupling_gap_mm / grid_.step_mm + 1e-9));
  for (int l = 0; l < label_.lines(); ++l) {
    int k = 0;
    while (k < label_.samples() && label_.row(k)[l] == 0.0F) ++k;
    begins_[static_cast<std::size_t>(l)] = k <= gap ? k : label_.samples();
  }
}

/// Row by row, as the samples lie in memory.
void AlamillaRenderer::FindSurfaces(int first, int count) {
  std::array<int, kLinesPerPiece> before;
  before.fill(-1);
  std::fill_n(num_surfaces_.begin() + first, count, 0);
  for (int k = 0; k < label_.samples(); ++k) {
    const float* const labels = label_.row(k) + first;
    for (int n = 0; n < count; ++n) {
      const auto l = static_cast<std::size_t>(first + n);
      if (k < begins_[l]) continue;
      int& last = before[static_cast<std::size_t>(n)];
      const int label = std::min(kNeedle, static_cast<int>(labels[n]));
      if (label != last && last >= 0 && num_surfaces_[l] < kMaxSurfaces) {
        surface_[l * kMaxSurfaces + static_cast<std::size_t>(num_surfaces_[l]++)] = {k, label,
                                                                                     0.0F};
      }
      last = label;
    }
  }
}

float AlamillaRenderer::SlopeOf(int line, const Surface& surface) const {
  const double lateral_mm =
      grid_.lines() > 1 ? grid_.LateralSpacingMm(surface.sample) : kSlopeReachMm;
  const int reach = std::max(1, static_cast<int>(std::lround(kSlopeReachMm / lateral_mm)));
  int low = line;
  int high = line;
  int low_sample = surface.sample;
  int high_sample = surface.sample;
  // Follows the depth map to both sides as long as it continues.
  const auto follow = [&](int step, int& at, int& sample) {
    for (int n = 0; n < reach; ++n) {
      const int next = at + step;
      if (next < 0 || next >= grid_.lines()) return;
      const Surface* other = surface_.data() + static_cast<std::ptrdiff_t>(next) * kMaxSurfaces;
      const int max_jump = 1 + static_cast<int>(3.0 * lateral_mm / grid_.step_mm);
      int best = max_jump + 1;
      int found = 0;
      for (int s = 0; s < num_surfaces_[static_cast<std::size_t>(next)]; ++s) {
        const int jump = std::abs(other[s].sample - sample);
        if (other[s].label == surface.label && jump < best) {
          best = jump;
          found = other[s].sample;
        }
      }
      if (best > max_jump) return;
      at = next;
      sample = found;
    }
  };
  follow(-1, low, low_sample);
  follow(1, high, high_sample);
  if (low == high) return 0.0F;
  return static_cast<float>((high_sample - low_sample) * grid_.step_mm /
                            ((high - low) * lateral_mm));
}

void AlamillaRenderer::WeighSurfaces(int line) {
  Surface* surfaces = surface_.data() + static_cast<std::ptrdiff_t>(line) * kMaxSurfaces;
  int before = static_cast<int>(
      label_.row(std::min(begins_[static_cast<std::size_t>(line)], label_.samples() - 1))[line]);
  before = std::min(before, kNeedle);
  for (int s = 0; s < num_surfaces_[static_cast<std::size_t>(line)]; ++s) {
    Surface& surface = surfaces[s];
    float grey = std::max(tissue_[static_cast<std::size_t>(before)].reflection,
                          tissue_[static_cast<std::size_t>(surface.label)].reflection);
    if (options_.angle_exponent > 0 && surface.label != kNeedle) {
      const float slope = SlopeOf(line, surface);
      const float cosine_squared = 1.0F / (1.0F + slope * slope);
      float weight = options_.angle_exponent % 2 != 0 ? std::sqrt(cosine_squared) : 1.0F;
      for (int n = 1; n < options_.angle_exponent; n += 2) weight *= cosine_squared;
      grey *= weight;
    }
    surface.grey = grey;
    before = surface.label;
  }
}

float AlamillaRenderer::BlurredNoise(int k, int line) const {
  const auto l = static_cast<std::size_t>(line);
  const Eigen::Vector3f index(
      lines_.start[0].data()[l] + static_cast<float>(k) * lines_.step[0].data()[l],
      lines_.start[1].data()[l] + static_cast<float>(k) * lines_.step[1].data()[l],
      lines_.start[2].data()[l] + static_cast<float>(k) * lines_.step[2].data()[l]);
  const auto label = static_cast<volume::Label>(label_.row(k)[line]);
  const Eigen::Vector3d fibre = probe_from_ct_ * fibres_->At(label, index).cast<double>();
  const Eigen::Vector2d beam = grid_.direction[l];
  const double lateral_mm = grid_.lines() > 1 ? grid_.LateralSpacingMm(k) : 1.0;
  // Steps along the fibre's part in the plane: a fibre across the plane is a dot.
  const double down = fibre.head<2>().dot(beam) / grid_.step_mm;
  const double aside = (fibre[0] * beam[1] - fibre[1] * beam[0]) / lateral_mm;
  const double half = 0.5 * options_.thin_fibre_mm * std::max(std::abs(down), std::abs(aside));
  const int taps = std::min(kMaxTaps, static_cast<int>(half));
  if (taps == 0 || grid_.lines() < 2 || grid_.samples < 2) return noise_.row(k)[line];
  const double step_mm = 0.5 * options_.thin_fibre_mm / taps;
  return kernels::MeanAlong({.data = noise_.row(0),
                             .stride = noise_.stride(),
                             .lines = grid_.lines(),
                             .samples = grid_.samples},
                            static_cast<float>(line), static_cast<float>(k),
                            static_cast<float>(step_mm * aside), static_cast<float>(step_mm * down),
                            taps);
}

/// Row by row, as the samples lie in memory.
void AlamillaRenderer::ShadeLines(int first, int count) {
  struct Shade {
    const Surface* surface;  ///< The next one.
    const Surface* end;
    int begin;
    float left = 1.0F;  ///< Of the grey, after absorption.
    int shadow_from;
    int needle_shadow_from;
    int line_from;
    float line_grey = 0.0F;
  };
  const int thick = std::max(1, static_cast<int>(std::lround(options_.surface_mm / grid_.step_mm)));
  const auto shadow_share = static_cast<float>(options_.shadow_share);
  const auto needle_share = static_cast<float>(options_.needle_share);
  std::array<Shade, kLinesPerPiece> shades;
  for (int n = 0; n < count; ++n) {
    const auto l = static_cast<std::size_t>(first + n);
    const Surface* surface = surface_.data() + l * kMaxSurfaces;
    shades[static_cast<std::size_t>(n)] = {.surface = surface,
                                           .end = surface + num_surfaces_[l],
                                           .begin = begins_[l],
                                           .shadow_from = grid_.samples,
                                           .needle_shadow_from = grid_.samples,
                                           .line_from = -thick};
  }
  for (int k = 0; k < grid_.samples; ++k) {
    const float* const labels = label_.row(k) + first;
    const float* const noises = noise_.row(k) + first;
    float* const greys = grey_.row(k) + first;
    for (int n = 0; n < count; ++n) {
      Shade& s = shades[static_cast<std::size_t>(n)];
      if (k < s.begin) {
        greys[n] = 0.0F;
        continue;
      }
      const int label = std::min(kNeedle, static_cast<int>(labels[n]));
      const TissueRow& tissue = tissue_[static_cast<std::size_t>(label)];
      float grey = tissue.grey;
      if (noise_tile_) {
        const float noise = tissue.thin_fibres ? BlurredNoise(k, first + n) : noises[n];
        grey *= std::max(0.0F, 1.0F + tissue.contrast * (2.0F * noise - 1.0F));
      }
      if (options_.shadow && label == kNeedle) {
        s.needle_shadow_from = std::min(s.needle_shadow_from, k + thick);
      }
      if (options_.shadow && tissue.blocks) s.shadow_from = std::min(s.shadow_from, k + thick);
      if (options_.reflection && s.surface != s.end && s.surface->sample == k) {
        s.line_from = k;
        s.line_grey = s.surface->grey;
        ++s.surface;
      }
      const int behind = k - s.line_from;
      if (behind < thick) {
        grey += s.line_grey * (1.0F - static_cast<float>(behind) / static_cast<float>(thick));
      }
      grey *= s.left * (k >= s.shadow_from          ? shadow_share
                        : k >= s.needle_shadow_from ? needle_share
                                                    : 1.0F);
      s.left *= tissue.passed;
      greys[n] = grey;
    }
  }
}

void AlamillaRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                              const std::optional<image::NeedleInImage>& needle,
                              image::GrayImage& out, int num_threads,
                              const slicing::RestMap* rest) {
  const bool shifts = rest != nullptr && options_.displaces_pixels;
  slicing::PlaceLines(grid_, index_from_ct_, ct_from_probe, lines_);
  bend_.Set(grid_, ct_from_probe, index_from_ct_, shifts ? nullptr : rest);
  probe_from_ct_ = ct_from_probe.linear().transpose();
  TurnExamples(ct_from_probe.linear().col(2));
  label_.Resize(grid_.lines(), grid_.samples);
  noise_.Resize(grid_.lines(), grid_.samples);
  grey_.Resize(grid_.lines(), grid_.samples);
  const auto lines = static_cast<std::size_t>(grid_.lines());
  surface_.resize(lines * kMaxSurfaces);
  num_surfaces_.resize(lines);
  begins_.resize(lines);

  if (traced_) traced_->Fill(lines_, bend_, num_threads, label_);
  const auto rows = [this](int p) {
    const int end = std::min(grid_.samples, (p + 1) * kRowsPerPiece);
    for (int k = p * kRowsPerPiece; k < end; ++k) SampleRow(k);
  };
  ParallelFor((grid_.samples + kRowsPerPiece - 1) / kRowsPerPiece, num_threads, std::ref(rows));
  FillCoupling();
  if (needle) {
    slicing::PaintNeedle(shifts ? NeedleAtRest(*needle, *rest) : *needle, ct_from_probe,
                         probe_.slice_thickness_mm, grid_, label_);
  }
  const auto find = [this](int p) {
    FindSurfaces(p * kLinesPerPiece, std::min(kLinesPerPiece, grid_.lines() - p * kLinesPerPiece));
  };
  const int pieces = (grid_.lines() + kLinesPerPiece - 1) / kLinesPerPiece;
  ParallelFor(pieces, num_threads, std::ref(find));
  const auto shade = [this](int p) {
    const int end = std::min(grid_.lines(), (p + 1) * kLinesPerPiece);
    for (int l = p * kLinesPerPiece; options_.reflection && l < end; ++l) WeighSurfaces(l);
    ShadeLines(p * kLinesPerPiece, end - p * kLinesPerPiece);
  };
  ParallelFor(pieces, num_threads, std::ref(shade));
  const auto black = static_cast<float>(255.0 * brightness_);
  const auto grey_row = [this, black](int k, int, std::uint8_t* grey) {
    slicing::kernels::WindowRow(grey_.row(k), black, 255.0F,
                                slicing::kernels::RoundUp(grey_.lines()), grey);
  };
  conversion_.Show(std::ref(grey_row), out, num_threads);
  if (shifts) shift_.Apply(conversion_.image(), ct_from_probe, *rest, out);
}

}  // namespace acus::ultrasound
