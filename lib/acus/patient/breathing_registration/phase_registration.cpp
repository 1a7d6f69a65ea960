#include "acus/patient/breathing_registration/phase_registration.h"

#include <cmath>
#include <memory>
#include <numeric>

#include "acus/base/core/parallel.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kWallMm = 1e6;  // Where nothing slides, all is far from the wall.
constexpr double kDefaultMm = 2.0, kCoarsestMm = 20.0;  // Spacing of the finest grid.
constexpr double kMostNodes = 1.3e6, kCountedMm = 8.0;  // Of the default; tissue is counted so.
constexpr float kOutlier = 8.0F;                        // In units of noise, on the finest grid.
constexpr float kDoubtfulMm = 32.0F;  // From the border, before any motion is known.
constexpr double kMixedNodes = 3.0;   // From the wall: voxels there are averages of both sides.
constexpr float kCoarser = 4.0F;  // Times more on each coarser one: there edges are far apart yet.

struct Domain {
  std::shared_ptr<const SlidingGrid> grid;
  std::vector<float> wall_mm, trust;
};

Domain MakeDomain(const volume::Geometry& geometry, const Tissue& tissue, int num_threads) {
  const Eigen::Affine3d ct_from_index = geometry.ct_from_index();
  const double h = geometry.spacing_mm[0];
  std::vector<Side> side(geometry.num_voxels(), Side::kNone);
  std::vector<Vector3f> normal(geometry.num_voxels(), Vector3f::Zero());
  std::vector<float> distance(geometry.num_voxels(), static_cast<float>(kWallMm));
  ParallelFor(geometry.size[2], num_threads, [&](int k) {
    for (int j = 0; j < geometry.size[1]; ++j) {
      for (int i = 0; i < geometry.size[0]; ++i) {
        const Vector3d p = ct_from_index * Vector3d(i, j, k);
        if (!tissue.is_tissue(p)) continue;
        const std::size_t v = geometry.Index(i, j, k);
        side[v] = Side::kWall;
        if (!tissue.wall_mm) continue;
        const double wall_mm = tissue.wall_mm(p);
        if (wall_mm < 0.0) side[v] = Side::kCavity;
        distance[v] = static_cast<float>(wall_mm);
        if (std::abs(wall_mm) > 3.0 * h) continue;
        Vector3d slope;
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3d d = 0.5 * h * geometry.direction.col(axis);
          slope[axis] = tissue.wall_mm(p + d) - tissue.wall_mm(p - d);
        }
        if (slope.norm() > 1e-6) normal[v] = slope.normalized().cast<float>();
      }
    }
  });
  Domain domain{
      .grid = std::make_shared<SlidingGrid>(geometry, side, normal), .wall_mm = {}, .trust = {}};
  for (int n = 0; n < domain.grid->num_nodes(); ++n) {
    domain.wall_mm.push_back(std::abs(distance[domain.grid->Voxel(n)]));
    const double share = static_cast<double>(domain.wall_mm.back()) / (kMixedNodes * h);
    domain.trust.push_back(static_cast<float>(std::clamp(share, 0.1, 1.0)));
  }
  return domain;
}

SlidingGrid::Field Transferred(const SlidingGrid& from, const SlidingGrid::Field& u,
                               const SlidingGrid& to) {
  const auto scale =
      static_cast<float>(from.geometry().spacing_mm[0] / to.geometry().spacing_mm[0]);
  SlidingGrid::Field out(static_cast<std::size_t>(to.num_nodes()));
  for (int n = 0; n < to.num_nodes(); ++n) {
    const Vector3f index = to.IndexOf(n) / scale;
    out[static_cast<std::size_t>(n)] = scale * from.At(u, index, to.SideOf(n));
  }
  return out;
}

double RootMeanSquare(const SlidingGrid& grid, const volume::Grid<float>& difference) {
  double sum = 0.0;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    sum += std::pow(static_cast<double>(difference.voxels[grid.Voxel(n)]), 2.0);
  }
  return std::sqrt(sum / grid.num_nodes());
}

}  // namespace

Vector3d PhaseField::DisplacementMm(const Vector3d& rest_mm, Side side) const {
  const volume::Geometry& g = nodes();
  const Vector3d index = g.index_from_ct() * rest_mm;
  const Vector3d voxels = grid_->At(displacement_, index.cast<float>(), side).cast<double>();
  return g.direction * (g.spacing_mm * voxels.array()).matrix();
}

double PhaseField::BoundMm(const Vector3d& rest_mm, Side side) const {
  return bound_.Mm((nodes().index_from_ct() * rest_mm).cast<float>(), side);
}

bool PhaseField::IsUnseen(const Vector3d& rest_mm, Side side) const {
  return bound_.IsUnseen((nodes().index_from_ct() * rest_mm).cast<float>(), side);
}

std::vector<float> PhaseField::BoundOnNodes(const volume::Geometry& nodes_out, const Tissue& tissue,
                                            int num_threads) const {
  const Eigen::Affine3d ct_from_node = nodes_out.ct_from_index();
  std::vector<float> out(nodes_out.num_voxels(), 0.0F);
  ParallelFor(nodes_out.size[2], num_threads, [&](int k) {
    for (int j = 0; j < nodes_out.size[1]; ++j) {
      for (int i = 0; i < nodes_out.size[0]; ++i) {
        const Vector3d p = ct_from_node * Vector3d(i, j, k);
        if (!tissue.is_tissue(p)) continue;
        const bool in = tissue.wall_mm && tissue.wall_mm(p) < 0.0;
        out[nodes_out.Index(i, j, k)] =
            static_cast<float>(BoundMm(p, in ? Side::kCavity : Side::kWall));
      }
    }
  });
  return out;
}

std::vector<float> PhaseField::OnNodes(const volume::Geometry& nodes_out, const Tissue& tissue,
                                       int num_threads) const {
  const volume::Geometry& g = nodes();
  const std::vector<Vector3f> everywhere = grid_->Everywhere(displacement_);
  const Eigen::Matrix3f ct_from_voxels =
      (g.direction * g.spacing_mm.matrix().asDiagonal()).cast<float>();
  const Eigen::Affine3d index_from_node = g.index_from_ct() * nodes_out.ct_from_index();
  const Eigen::Affine3d ct_from_node = nodes_out.ct_from_index();
  std::vector<float> out(3 * nodes_out.num_voxels());
  ParallelFor(nodes_out.size[2], num_threads, [&](int k) {
    for (int j = 0; j < nodes_out.size[1]; ++j) {
      for (int i = 0; i < nodes_out.size[0]; ++i) {
        const Vector3d node(i, j, k);
        const Vector3f index = (index_from_node * node).cast<float>();
        const Eigen::Array3i nearest = index.array().round().cast<int>().max(0).min(g.size - 1);
        const std::size_t voxel = g.Index(nearest[0], nearest[1], nearest[2]);
        Vector3f u = everywhere[voxel];
        if (grid_->NodeAt(voxel) >= 0) {
          const bool in = tissue.wall_mm && tissue.wall_mm(ct_from_node * node) < 0.0;
          u = grid_->At(displacement_, index, in ? Side::kCavity : Side::kWall);
        }
        const Vector3f mm = ct_from_voxels * u;
        std::ranges::copy(mm,
                          out.begin() + static_cast<std::ptrdiff_t>(3 * nodes_out.Index(i, j, k)));
      }
    }
  });
  return out;
}

double DefaultSpacingMm(const volume::Geometry& ct, const Tissue& tissue, int num_threads) {
  const volume::Geometry coarse = CubicGrid(ct, kCountedMm);
  const Eigen::Affine3d ct_from_index = coarse.ct_from_index();
  std::vector<double> in_plane(static_cast<std::size_t>(coarse.size[2]), 0.0);
  ParallelFor(coarse.size[2], num_threads, [&](int k) {
    for (int j = 0; j < coarse.size[1]; ++j) {
      for (int i = 0; i < coarse.size[0]; ++i) {
        const bool counts = tissue.is_tissue(ct_from_index * Vector3d(i, j, k));
        in_plane[static_cast<std::size_t>(k)] += counts ? 1.0 : 0.0;
      }
    }
  });
  const double count = std::accumulate(in_plane.begin(), in_plane.end(), 0.0);
  return std::clamp(std::max(ct.spacing_mm.maxCoeff(), kCountedMm * std::cbrt(count / kMostNodes)),
                    kDefaultMm, kCoarsestMm);
}

PhaseRegistration::PhaseRegistration(const volume::CtVolume& reference, const Tissue& tissue,
                                     const RegistrationSettings& settings,
                                     const RunContext& context)
    : settings_(settings), ct_(reference.geometry) {
  if (settings.spacing_mm == 0.0) {
    settings_.spacing_mm = DefaultSpacingMm(ct_, tissue, context.num_threads);
  }
  ACUS_REQUIRE(settings_.spacing_mm >= 0.5 && settings_.spacing_mm <= kCoarsestMm,
               "registration: a grid of ", settings_.spacing_mm, " mm; it must be in [0.5, 20]");
  ACUS_REQUIRE(settings.levels >= 1 && settings.levels <= 6, "registration: ", settings.levels,
               " levels; 1 to 6 are possible");
  ACUS_REQUIRE(settings.smoothness > 0.0 && settings.noise > 0.0,
               "registration: smoothness and noise must be above 0");
  volume::Grid<float> image;
  for (int n = 0; n < settings.levels; ++n) {
    context.Checkpoint("preparing the reference", static_cast<double>(n) / settings.levels);
    const volume::Geometry grid = CubicGrid(ct_, settings_.spacing_mm * (1 << n));
    if (n > 0 && (grid.size < 8).any()) break;
    image = n == 0 ? Averaged(reference, grid, context.num_threads)
                   : Averaged(image, grid, context.num_threads);
    Domain domain = MakeDomain(grid, tissue, context.num_threads);
    ACUS_REQUIRE(domain.grid->num_nodes() > 0, "registration: there is no tissue in the reference");
    levels_.push_back({.grid = std::move(domain.grid),
                       .reference = std::make_shared<ModelImage>(image, context.num_threads),
                       .outlier = kOutlier * std::pow(kCoarser, static_cast<float>(n)),
                       .wall_mm = std::move(domain.wall_mm),
                       .trust = std::move(domain.trust)});
  }
}

PhaseRegistration::Match PhaseRegistration::MatchOf(const Level& level, int node, const Vector3f& u,
                                                    const ModelImage& phase,
                                                    const EnteredTissue& entered,
                                                    const LungDensity& density) const {
  const std::size_t v = level.grid->Voxel(node);
  const Vector3f at = level.grid->IndexOf(node) + u;
  const ModelImage::Sample moved = phase.At(at);
  if (!moved.within || entered.Holds(at)) return {};
  const auto noise = static_cast<float>(settings_.noise);
  const Eigen::Array4f& rest = level.reference->Voxel(v);
  const LungDensity::Look expected = density.At(node, rest[0]);
  const float r = (moved.value - expected.contrast) / noise;
  const float doubt = 1.0F + r * r / (level.outlier * level.outlier);
  // The mean of both gradients converges faster than either.
  return {.gradient = 0.5F / noise * (moved.gradient + expected.slope * rest.tail<3>().matrix()),
          .residual = r,
          .root_weight = std::sqrt(level.trust[static_cast<std::size_t>(node)]) / doubt};
}

ErrorBound PhaseRegistration::BoundOf(const ModelImage& phase, const SlidingGrid::Field& u,
                                      const SlidingGrid::Field& coarser, int num_threads) const {
  const Level& level = levels_[0];
  const EnteredTissue entered(*level.grid, u);
  Solution solution{.displacement_voxels = u,
                    .coarser_voxels = coarser,
                    .is_seen = std::vector<std::uint8_t>(u.size()),
                    .wall_mm = level.wall_mm};
  for (int i = 0; i < level.grid->num_nodes(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    solution.is_seen[n] = MatchOf(level, i, u[n], phase, entered, {}).root_weight > 0.0F ? 1 : 0;
  }
  return {*level.grid, solution, num_threads};
}

SlidingGrid::Field PhaseRegistration::Refine(const Level& level, const ModelImage& phase,
                                             SlidingGrid::Field u, bool motion_known,
                                             int num_threads) const {
  const SlidingGrid& grid = *level.grid;
  const auto coarser = static_cast<float>(grid.geometry().spacing_mm[0] / settings_.spacing_mm);
  const int count = grid.num_nodes();
  // Coarse grids say where tissue went as a whole, fine ones what remains: smoother first.
  const float stiffness = static_cast<float>(settings_.smoothness) * coarser * coarser;
  DataTerm data{.gradient = SlidingGrid::Field(u.size()), .force = SlidingGrid::Field(u.size())};
  constexpr int kChunk = 8192;
  for (int iteration = 0; iteration < settings_.iterations; ++iteration) {
    const bool guess = !motion_known && 2 * iteration < settings_.iterations;
    const EnteredTissue entered =
        guess ? EnteredTissue(grid, kDoubtfulMm / static_cast<float>(grid.geometry().spacing_mm[0]))
              : EnteredTissue(grid, u);
    const LungDensity density(grid, u, *level.reference, phase, num_threads);
    ParallelFor((count + kChunk - 1) / kChunk, num_threads, [&](int c) {
      for (int i = c * kChunk; i < std::min(count, (c + 1) * kChunk); ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Match match = MatchOf(level, i, u[n], phase, entered, density);
        data.gradient[n] = match.root_weight * match.gradient;
        data.force[n] = -stiffness * grid.Pull(u, i) -
                        match.root_weight * match.root_weight * match.residual * match.gradient;
      }
    });
    const SlidingGrid::Field step =
        SolveStep(grid, data, stiffness, settings_.solver_iterations, num_threads);
    for (std::size_t n = 0; n < u.size(); ++n) {
      // Beyond a voxel or two the linearisation says nothing.
      const float length = step[n].norm();
      u[n] += (length > 2.0F ? 2.0F / length : 1.0F) * step[n];
    }
  }
  return u;
}

PhaseField PhaseRegistration::Register(const volume::CtVolume& phase, const PhaseField* start,
                                       const RunContext& context, Residual* residual) const {
  ACUS_REQUIRE(phase.geometry.Matches(ct_), "registration: a phase of ",
               phase.geometry.size.transpose(), " voxels at ", phase.geometry.origin_mm.transpose(),
               " mm, but the reference has ", ct_.size.transpose(), " at ",
               ct_.origin_mm.transpose(), " mm; all phases must lie on the same grid");
  std::vector<ModelImage> images;
  volume::Grid<float> image;
  for (std::size_t n = 0; n < levels_.size(); ++n) {
    const volume::Geometry& grid = levels_[n].grid->geometry();
    image = n == 0 ? Averaged(phase, grid, context.num_threads)
                   : Averaged(image, grid, context.num_threads);
    images.emplace_back(image, context.num_threads);
  }
  const std::size_t coarsest = levels_.size() - 1;
  SlidingGrid::Field u(static_cast<std::size_t>(levels_[coarsest].grid->num_nodes()),
                       Vector3f::Zero());
  if (start != nullptr) {
    u = Transferred(start->grid(), start->displacement_voxels(), *levels_[coarsest].grid);
  }
  SlidingGrid::Field coarser = u;
  for (std::size_t n = levels_.size(); n-- > 0;) {
    if (n != coarsest) u = Transferred(*levels_[n + 1].grid, u, *levels_[n].grid);
    if (n == 0) coarser = u;
    u = Refine(levels_[n], images[n], std::move(u), n != coarsest, context.num_threads);
  }
  ErrorBound bound = BoundOf(images[0], u, coarser, context.num_threads);
  PhaseField field(levels_[0].grid, std::move(u), std::move(bound));
  if (residual != nullptr) {
    *residual = {.before = RootMeanSquare(*levels_[0].grid, Difference(images[0], nullptr)),
                 .after = RootMeanSquare(*levels_[0].grid, Difference(images[0], &field))};
  }
  return field;
}

volume::Grid<float> PhaseRegistration::Difference(const ModelImage& phase,
                                                  const PhaseField* field) const {
  const SlidingGrid& grid = *levels_[0].grid;
  volume::Grid<float> out(grid.geometry());
  for (int i = 0; i < grid.num_nodes(); ++i) {
    const std::size_t v = grid.Voxel(i);
    Vector3f at = grid.IndexOf(i);
    if (field != nullptr) at += field->displacement_voxels()[static_cast<std::size_t>(i)];
    const ModelImage::Sample moved = phase.At(at);
    if (moved.within) out.voxels[v] = moved.value - levels_[0].reference->Voxel(v)[0];
  }
  return out;
}

volume::Grid<float> PhaseRegistration::Difference(const volume::CtVolume& phase,
                                                  const PhaseField* field, int num_threads) const {
  const volume::Geometry& grid = levels_[0].grid->geometry();
  return Difference(ModelImage(Averaged(phase, grid, num_threads), num_threads), field);
}

}  // namespace acus::breathing_registration
