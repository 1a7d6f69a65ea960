#include "acus/imaging/ultrasound/aperture_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/ultrasound/beam_interface.h"
#include "acus/imaging/ultrasound/beam_kernels.h"

namespace acus::ultrasound {
namespace {

constexpr float kGasZeta = 0.0F;
/// The window that smooths tissue reaches this far, voxels: so does a boundary's slope.
constexpr double kSlopeVoxels = 2.0;
constexpr double kFlattestSlopePerMm = 0.0005;
constexpr std::size_t kCrossingsPerLine = 64;
/// An oblique surface lies in the pulse for a part of the beam's width only. Its echo is raised by
/// this at most.
constexpr double kMostObliqueGain = 6.0;
/// Root mean square height of the surfaces of tissues. Estimate.
constexpr double kRoughnessMm = 0.03;
constexpr double kNepersPerDb = std::numbers::ln10 / 20.0;

}  // namespace

ApertureTracer::ApertureTracer(const AcousticVolume& volume, const ApertureOptions& options,
                               const BeamFilter& filter, const acoustics::ScanGrid& grid,
                               const Eigen::Array3d& spacing_mm, int fine_per_row,
                               double wavelength_mm)
    : volume_(volume),
      options_(options),
      filter_(filter),
      grid_(grid),
      spacing_mm_(spacing_mm),
      fine_per_row_(fine_per_row),
      wave_number_per_mm_(2.0 * std::numbers::pi / wavelength_mm),
      gel_rows_(static_cast<int>(options.coupling_gap_mm / grid.step_mm + 1e-9)),
      skin_rows_(static_cast<int>(std::ceil(kSlopeVoxels * spacing_mm.maxCoeff() / grid.step_mm))) {
  scatter2_.Resize(grid.lines(), grid.samples);
  contact_.assign(static_cast<std::size_t>(kernels::RoundUp(grid.lines())), 1.0F);
  smooth_contact_ = contact_;
  work_.resize(static_cast<std::size_t>((grid.lines() + kLanesPerBlock - 1) / kLanesPerBlock));
  for (Work& work : work_) {
    work.crossings.reserve(kCrossingsPerLine * kLanesPerBlock *
                           static_cast<std::size_t>(options.elevation_planes));
  }
}

void ApertureTracer::TraceBlock(const std::vector<AperturePlane>& planes, int block,
                                ApertureField& field) {
  work_[static_cast<std::size_t>(block)].crossings.clear();
  double weight = 0.0;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    weight += planes[p].weight;
    TracePlane(planes[p], weight, block, field);
  }
}

void ApertureTracer::TracePlane(const AperturePlane& plane, double weight_so_far, int block,
                                ApertureField& field) {
  const bool first_plane = weight_so_far == plane.weight;
  const int first = block * kLanesPerBlock;
  const int lanes = std::min(kLanesPerBlock, kernels::RoundUp(grid_.lines()) - first);
  Work& work = work_[static_cast<std::size_t>(block)];
  std::fill_n(work.moment, kLanesPerBlock, 0.0F);
  std::fill_n(work.quiet_until, kLanesPerBlock, 1);
  std::fill_n(work.dry, kLanesPerBlock, true);
  const auto strong =
      static_cast<float>(options_.shadow ? options_.strong_loss_db_per_mm * kNepersPerDb : 0.0);
  for (int k = 0; k < grid_.samples; ++k) {
    const int piece = plane.path.PieceAt(k);
    kernels::SampleAcousticRow(volume_.voxels(), plane.path.Voxels(piece, first),
                               static_cast<float>(k), lanes,
                               {work.zeta, work.nepers, work.scatter, work.seen});
    if (k <= gel_rows_ + skin_rows_) MeetSkin(work, first, lanes, k, first_plane);
    kernels::AddLossRow({.zeta = work.zeta,
                         .nepers = work.nepers,
                         .scatter = work.scatter,
                         .seen = work.seen,
                         .step_mm = static_cast<float>(k == 0 ? 0.0 : grid_.step_mm),
                         .strong_nepers = strong,
                         .weight = static_cast<float>(plane.weight),
                         .add = !first_plane,
                         .left = field.left(k) + first,
                         .scatter2 = scatter2_.row(k) + first},
                        lanes);
    if (!options_.interfaces) continue;
    const bool any = kernels::FindInterfacesRow(
        {.log_impedance = work.zeta,
         .previous = work.previous,
         .start = work.start,
         .moment = work.moment,
         .run = work.run,
         .place = work.place,
         .k = static_cast<float>(k),
         .min_step = static_cast<float>(kFlattestSlopePerMm * grid_.step_mm),
         .min_run = static_cast<float>(std::atanh(options_.smallest_reflection))},
        lanes);
    if (any) AddCrossings(plane, weight_so_far, block, k, lanes, field);
  }
}

void ApertureTracer::MeetSkin(Work& work, int first, int lanes, int k, bool first_plane) {
  for (int l = 0; l < lanes; ++l) {
    const bool air = work.zeta[l] < kGasZeta;
    if (work.dry[l] && air) {
      // Gel fills a gap; a face that sees nothing but air radiates nothing into the body.
      work.zeta[l] = 0.0F;
      work.nepers[l] = 0.0F;
      work.scatter[l] = 0.0F;
      work.quiet_until[l] = k + 2;
      if (k >= gel_rows_) work.dry[l] = false;
      if (first_plane) contact_[static_cast<std::size_t>(first + l)] = 0.0F;
    } else if (work.dry[l]) {
      work.dry[l] = false;
      if (first_plane) contact_[static_cast<std::size_t>(first + l)] = 1.0F;
      work.quiet_until[l] = k > 0 ? k + 1 + skin_rows_ : 1;
    }
    if (k < work.quiet_until[l]) {
      work.previous[l] = work.start[l] = work.zeta[l];
      work.moment[l] = 0.0F;
    }
  }
}

const std::vector<float>& ApertureTracer::SmoothContact() {
  const int reach = std::max(1, grid_.lines() / 24);
  for (int l = 0; l < grid_.lines(); ++l) {
    float sum = 0.0F;
    for (int n = l - reach; n <= l + reach; ++n) {
      sum += contact_[static_cast<std::size_t>(std::clamp(n, 0, grid_.lines() - 1))];
    }
    smooth_contact_[static_cast<std::size_t>(l)] = sum / static_cast<float>(2 * reach + 1);
  }
  return smooth_contact_;
}

void ApertureTracer::AddCrossings(const AperturePlane& plane, double weight_so_far, int block,
                                  int k, int lanes, ApertureField& field) {
  Work& work = work_[static_cast<std::size_t>(block)];
  const int first = block * kLanesPerBlock;
  for (int l = 0; l < lanes && first + l < grid_.lines(); ++l) {
    const float change = work.run[l];
    if (change == 0.0F || work.crossings.size() == work.crossings.capacity()) continue;
    const float row = std::clamp(work.place[l], 0.0F, static_cast<float>(k));
    const slicing::kernels::Lines lines =
        plane.path.Voxels(plane.path.PieceAt(static_cast<int>(row)), first);
    const int other = l + 1 < lanes ? l + 1 : l - 1;
    Eigen::Vector3d index;
    Eigen::Vector3d step;
    Eigen::Vector3d across;
    for (int a = 0; a < 3; ++a) {
      step[a] = lines.step[a][l];
      index[a] = lines.start[a][l] + row * step[a];
      across[a] = lines.start[a][other] + row * lines.step[a][other] - index[a];
    }
    double reflection = std::tanh(double{change});
    double towards_probe = 1.0;
    double cosine = 1.0;
    const Eigen::Vector3d along = (step.array() * spacing_mm_).matrix().normalized();
    if (options_.angle) {
      const Eigen::Vector3d normal = volume_.NormalAt(index);
      if (!normal.isZero(0.0)) {
        cosine = std::min(1.0, std::abs(along.dot(normal)));
        const Eigen::Vector3d across_mm = across.array() * spacing_mm_;
        const Eigen::Vector3d sideways = (across_mm - along.dot(across_mm) * along).normalized();
        const double tan_in_plane = std::abs(sideways.dot(normal)) / std::max(cosine, 1e-3);
        const int sample = static_cast<int>(row) * fine_per_row_;
        const double oblique = filter_.AcrossOverAlong(sample) * tan_in_plane;
        towards_probe = MirrorLobe(cosine, options_.lobe_deg, options_.diffuse_share) *
                        std::min(kMostObliqueGain, std::sqrt(1.0 + oblique * oblique));
      }
    }
    // A surface whose heights vary by sigma reflects exp(-2 (k sigma cos)^2) of a mirror's
    // amplitude (Beckmann and Spizzichino); the rest is scattered.
    double coherent = 1.0;
    if (options_.rough_layer_mm > 0.0) {
      const double phase = wave_number_per_mm_ * kRoughnessMm * cosine;
      coherent = std::exp(-2.0 * phase * phase);
    }
    const double voxels_per_row = std::max(1e-3, step.norm());
    work.crossings.push_back(
        {.row = row,
         .lead = static_cast<float>(kSlopeVoxels / voxels_per_row),
         .line = first + l,
         .echo = static_cast<float>(plane.weight * reflection * towards_probe * coherent),
         .rough = static_cast<float>(plane.weight * std::abs(reflection) * towards_probe),
         .reflection = static_cast<float>(reflection),
         .index = index.cast<float>()});
    // Behind it, there and back, 1 - R^2 is left: the root of it one way.
    const double lost = 1.0 - std::sqrt(std::max(1e-4, 1.0 - reflection * reflection));
    const int behind = std::min(grid_.samples - 1, static_cast<int>(row) + 1);
    field.left(behind)[first + l] *= static_cast<float>(1.0 - lost * plane.weight / weight_so_far);
  }
}

}  // namespace acus::ultrasound
