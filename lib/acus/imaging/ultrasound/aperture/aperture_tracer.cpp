#include "acus/imaging/ultrasound/aperture/aperture_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"

namespace acus::ultrasound {
namespace {

constexpr float kGasZeta = 0.0F;
/// The window that smooths tissue reaches this far, voxels: so does a boundary's slope.
constexpr double kSlopeVoxels = 2.0;
constexpr double kFlattestSlopePerMm = 0.0005;
constexpr std::size_t kCrossingsPerLine = 64;
/// Root mean square height of the surfaces of tissues. Estimate.
constexpr double kRoughnessMm = 0.03;
/// Reflections stronger than those between soft tissues, and weaker than that of whole bone.
constexpr double kLeastPartOfBone = 0.11;
constexpr double kMostPartOfBone = 0.55;
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
      skin_rows_(static_cast<int>(std::ceil(kSlopeVoxels * spacing_mm.maxCoeff() / grid.step_mm))),
      min_run_(static_cast<float>(std::atanh(options.smallest_reflection))),
      strong_nepers_(
          static_cast<float>(options.shadow ? options.strong_loss_db_per_mm * kNepersPerDb : 0.0)) {
  scatter2_.Resize(grid.lines(), grid.samples);
  contact_.assign(static_cast<std::size_t>(kernels::RoundUp(grid.lines())), 1.0F);
  smooth_contact_ = contact_;
  work_.resize(static_cast<std::size_t>((grid.lines() + kLanesPerBlock - 1) / kLanesPerBlock));
  for (Work& work : work_) {
    work.planes.resize(static_cast<std::size_t>(options.elevation_planes));
    work.crossings.reserve(kCrossingsPerLine * kLanesPerBlock *
                           static_cast<std::size_t>(options.elevation_planes));
  }
}

void ApertureTracer::TraceBlock(const std::vector<AperturePlane>& planes, int block,
                                ApertureField& field) {
  Work& work = work_[static_cast<std::size_t>(block)];
  work.crossings.clear();
  for (PlaneState& state : work.planes) {
    std::fill_n(state.moment, kLanesPerBlock, 0.0F);
    std::fill_n(state.quiet_until, kLanesPerBlock, 1);
    std::fill_n(state.dry, kLanesPerBlock, true);
  }
  const int first = block * kLanesPerBlock;
  const int lanes = std::min(kLanesPerBlock, kernels::RoundUp(grid_.lines()) - first);
  // Row by row through all planes: they read neighbouring voxels.
  for (int k = 0; k < grid_.samples; ++k) {
    double weight = 0.0;
    for (std::size_t p = 0; p < planes.size(); ++p) {
      weight += planes[p].weight;
      TraceRow({.plane = planes[p],
                .state = work.planes[p],
                .block = block,
                .first = first,
                .lanes = lanes,
                .first_plane = p == 0,
                .weight_so_far = weight},
               k, field);
    }
  }
}

void ApertureTracer::TraceRow(const Pass& pass, int k, ApertureField& field) {
  Work& work = work_[static_cast<std::size_t>(pass.block)];
  const BeamPath& path = pass.plane.path;
  kernels::SampleAcousticRow(volume_.voxels(), path.Voxels(path.PieceAt(k), pass.first),
                             static_cast<float>(k), pass.lanes,
                             {work.zeta, work.nepers, work.scatter, work.seen});
  if (k <= gel_rows_ + skin_rows_) MeetSkin(work, pass, k);
  kernels::AddLossRow({.zeta = work.zeta,
                       .nepers = work.nepers,
                       .scatter = work.scatter,
                       .seen = work.seen,
                       .step_mm = static_cast<float>(k == 0 ? 0.0 : grid_.step_mm),
                       .strong_nepers = strong_nepers_,
                       .weight = static_cast<float>(pass.plane.weight),
                       .add = !pass.first_plane,
                       .left = field.left(k) + pass.first,
                       .scatter2 = scatter2_.row(k) + pass.first},
                      pass.lanes);
  if (!options_.interfaces) return;
  const bool any = kernels::FindInterfacesRow(
      {.log_impedance = work.zeta,
       .previous = pass.state.previous,
       .start = pass.state.start,
       .moment = pass.state.moment,
       .run = work.run,
       .place = work.place,
       .k = static_cast<float>(k),
       .min_step = static_cast<float>(kFlattestSlopePerMm * grid_.step_mm),
       .min_run = min_run_},
      pass.lanes);
  if (any) AddCrossings(pass, k, field);
}

void ApertureTracer::MeetSkin(Work& work, const Pass& pass, int k) {
  PlaneState& state = pass.state;
  for (int l = 0; l < pass.lanes; ++l) {
    const bool air = work.zeta[l] < kGasZeta;
    const auto line = static_cast<std::size_t>(pass.first + l);
    if (state.dry[l] && air) {
      // Gel fills a gap; a face that sees nothing but air radiates nothing into the body.
      work.zeta[l] = 0.0F;
      work.nepers[l] = 0.0F;
      work.scatter[l] = 0.0F;
      state.quiet_until[l] = k + 2;
      if (k >= gel_rows_) state.dry[l] = false;
      if (pass.first_plane) contact_[line] = 0.0F;
    } else if (state.dry[l]) {
      state.dry[l] = false;
      if (pass.first_plane) contact_[line] = 1.0F;
      state.quiet_until[l] = k > 0 ? k + 1 + skin_rows_ : 1;
    }
    if (k < state.quiet_until[l]) {
      state.previous[l] = state.start[l] = work.zeta[l];
      state.moment[l] = 0.0F;
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

void ApertureTracer::AddCrossings(const Pass& pass, int k, ApertureField& field) {
  Work& work = work_[static_cast<std::size_t>(pass.block)];
  const BeamPath& path = pass.plane.path;
  for (int l = 0; l < pass.lanes && pass.first + l < grid_.lines(); ++l) {
    const float change = work.run[l];
    if (change == 0.0F || work.crossings.size() == work.crossings.capacity()) continue;
    Crossing at;
    at.row = std::clamp(work.place[l], 0.0F, static_cast<float>(k));
    const int row = static_cast<int>(at.row);
    const slicing::kernels::Lines lines = path.Voxels(path.PieceAt(row), pass.first);
    const int other = l + 1 < pass.lanes ? l + 1 : l - 1;
    for (int a = 0; a < 3; ++a) {
      at.step[a] = lines.step[a][l];
      at.index[a] = lines.start[a][l] + at.row * at.step[a];
      at.across[a] = lines.start[a][other] + at.row * lines.step[a][other] - at.index[a];
    }
    at.line = pass.first + l;
    at.weight = static_cast<float>(pass.plane.weight);
    const double reflection = std::tanh(double{change});
    at.reflection = static_cast<float>(reflection);
    at.lead = static_cast<float>(kSlopeVoxels) / std::max(1e-3F, at.step.norm());
    work.crossings.push_back(at);
    // Behind it, two-way, 1 - R^2 remains: the root of it one way. Rows above this one hold
    // all planes.
    const double lost = 1.0 - std::sqrt(std::max(1e-4, 1.0 - reflection * reflection));
    const int behind = std::min(k, row + 1);
    const double planes = behind < k ? 1.0 : pass.weight_so_far;
    field.left(behind)[at.line] *= static_cast<float>(1.0 - lost * pass.plane.weight / planes);
  }
}

ApertureTracer::SurfaceEcho ApertureTracer::EchoOf(const Crossing& at) const {
  double towards_probe = 1.0;
  double cosine = 1.0;
  Eigen::Vector3d normal =
      options_.angle ? volume_.NormalAt(at.index.cast<double>()) : Eigen::Vector3d::Zero();
  if (!normal.isZero(0.0)) {
    const Eigen::Vector3d along =
        (at.step.cast<double>().array() * spacing_mm_).matrix().normalized();
    const Eigen::Vector3d across_mm = at.across.cast<double>().array() * spacing_mm_;
    const Eigen::Vector3d sideways = (across_mm - along.dot(across_mm) * along).normalized();
    const double strength = std::abs(double{at.reflection});
    if (!options_.mean_speckle && strength > kLeastPartOfBone && strength < kMostPartOfBone) {
      // The smoothed edge of bone or gas beside the plane: its slope out of the plane is that of
      // the smoothing, not of the surface. Images that are matched with recorded ones place bone
      // better without this echo from beside the plane.
      const Eigen::Vector3d out_of_plane = along.cross(sideways);
      const Eigen::Vector3d in_plane = normal - out_of_plane.dot(normal) * out_of_plane;
      if (in_plane.norm() > 0.1) normal = in_plane.normalized();
    }
    cosine = std::min(1.0, std::abs(along.dot(normal)));
    const double tan_in_plane = std::abs(sideways.dot(normal)) / std::max(cosine, 1e-3);
    const int sample = static_cast<int>(at.row) * fine_per_row_;
    const double oblique = filter_.AcrossOverAlong(sample) * tan_in_plane;
    towards_probe = MirrorLobe(cosine, options_.lobe_deg, options_.diffuse_share) *
                    std::min(kMostObliqueGain, std::sqrt(1.0 + oblique * oblique));
  }
  // A surface whose heights vary by sigma reflects exp(-2 (k sigma cos)^2) of a mirror's
  // amplitude (Beckmann and Spizzichino); the rest is scattered.
  double coherent = 1.0;
  if (options_.rough_layer_mm > 0.0) {
    const double phase = wave_number_per_mm_ * kRoughnessMm * cosine;
    coherent = std::exp(-2.0 * phase * phase);
  }
  const double mirror = double{at.weight} * at.reflection * towards_probe;
  return {.mirror = static_cast<float>(mirror * coherent),
          .rough = static_cast<float>(std::abs(mirror))};
}

}  // namespace acus::ultrasound
