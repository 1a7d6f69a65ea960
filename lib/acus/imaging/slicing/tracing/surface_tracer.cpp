#include "acus/imaging/slicing/tracing/surface_tracer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::tracing {
namespace {

/// The scene reaches from minus to plus this, units.
constexpr double kHalfScene = 4194304.0;  // 2^22

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-1e300);
};

Box BoxOf(const std::vector<LabelledSurface>& surfaces) {
  Box box;
  for (const LabelledSurface& s : surfaces) {
    if (s.surface.nodes_mm.cols() == 0) continue;
    ACUS_REQUIRE(s.surface.nodes_mm.allFinite(),
                 "surfaces as triangles: a coordinate is not finite");
    box.low = box.low.cwiseMin(s.surface.nodes_mm.rowwise().minCoeff());
    box.high = box.high.cwiseMax(s.surface.nodes_mm.rowwise().maxCoeff());
  }
  return box;
}

/// What one segment of a path gathers.
struct Gathering {
  const std::vector<TreeSurface>& surfaces;
  Place from;
  Place to;
  double from_at;
  double per_share;
  std::vector<SurfaceTracer::Crossing>& out;
};

void Gather(void* context, std::uint32_t surface, std::uint32_t triangle) {
  auto& g = *static_cast<Gathering*>(context);
  const TreeSurface& s = g.surfaces[surface];
  SegmentCrossing crossing{};
  if (!Crosses(g.from, g.to, s.NodeOf(triangle, 0), s.NodeOf(triangle, 1), s.NodeOf(triangle, 2),
               crossing)) {
    return;
  }
  g.out.push_back({g.from_at + crossing.share * g.per_share, surface, crossing.turn});
}

}  // namespace

SurfaceTracer::Buffers::Buffers(const SurfaceTracer& tracer)
    : winding_(tracer.num_surfaces()), inside_((tracer.num_surfaces() + 63) / 64) {
  crossings_.reserve(kUsualCrossings);
}

SurfaceTracer::SurfaceTracer(std::vector<LabelledSurface> surfaces, int num_threads) {
  const Box box = BoxOf(surfaces);
  const double half_mm = 0.5 * (box.high - box.low).maxCoeff();
  // A power of two: nodes that are multiples of it stay where they are.
  if (half_mm > 0.0) unit_mm_ = std::exp2(std::ceil(std::log2(half_mm / (kHalfScene - 1.0))));
  middle_mm_ = (0.5 * (box.low + box.high) / unit_mm_).array().round() * unit_mm_;
  std::vector<TreeSurface> in_units(surfaces.size());
  for (std::size_t n = 0; n < surfaces.size(); ++n) {
    LabelledSurface& s = surfaces[n];
    const Eigen::Index nodes = s.surface.nodes_mm.cols();
    ACUS_REQUIRE(
        s.surface.triangles.size() == 0 ||
            (s.surface.triangles.minCoeff() >= 0 && s.surface.triangles.maxCoeff() < nodes),
        "surfaces as triangles: a triangle of surface ", n, " names a node that is not there");
    in_units[n].nodes = ((s.surface.nodes_mm.colwise() - middle_mm_) / unit_mm_)
                            .array()
                            .round()
                            .cast<std::int32_t>();
    in_units[n].triangles = std::move(s.surface.triangles);
    s.surface.nodes_mm.resize(3, 0);
    label_.push_back(s.label);
    oriented_.push_back(s.winding == mesh::Winding::kOriented);
  }
  tree_ = std::make_unique<TriangleTree>(std::move(in_units), num_threads);
}

Place SurfaceTracer::PlaceOf(const Eigen::Vector3d& place_mm) const noexcept {
  const auto limit = static_cast<double>(kMaxPlace);
  Place out;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const double units = std::round((place_mm[a] - middle_mm_[a]) / unit_mm_);
    out[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::clamp(units, -limit, limit));
  }
  return out;
}

/// A place outside of everything, behind the path's start.
Place SurfaceTracer::FarBehind(const PathPlace* path, std::size_t count) const noexcept {
  Eigen::Vector3d along = Eigen::Vector3d::UnitZ();
  if (count > 1) {
    const Eigen::Vector3d first = path[1].place_mm - path[0].place_mm;
    if (first.norm() > 0.0) along = first.normalized();
  }
  // Farther than the diagonal of the scene's box.
  return PlaceOf(path[0].place_mm - 4.0 * kHalfScene * unit_mm_ * along);
}

void SurfaceTracer::Turn(const Crossing& crossing, Buffers& buffers) const noexcept {
  const std::size_t n = crossing.surface;
  int& winding = buffers.winding_[n];
  winding += oriented_[n] ? crossing.turn : 1;
  const bool inside = oriented_[n] ? winding != 0 : winding % 2 != 0;
  const std::uint64_t bit = std::uint64_t{1} << (n % 64);
  if (inside) {
    buffers.inside_[n / 64] |= bit;
  } else {
    buffers.inside_[n / 64] &= ~bit;
  }
}

volume::Label SurfaceTracer::LabelInside(const Buffers& buffers) const noexcept {
  for (std::size_t word = buffers.inside_.size(); word-- > 0;) {
    const std::uint64_t bits = buffers.inside_[word];
    if (bits != 0) return label_[64 * word + 63 - static_cast<std::size_t>(std::countl_zero(bits))];
  }
  return 0;
}

void SurfaceTracer::Trace(std::span<const PathPlace> path, Buffers& buffers,
                          std::vector<LabelChange>& out) const {
  std::ranges::fill(buffers.winding_, 0);
  std::ranges::fill(buffers.inside_, 0);
  std::vector<Crossing>& crossings = buffers.crossings_;
  crossings.clear();
  Place from = PlaceOf(path[0].place_mm);
  if (!tree_->IsOutside(from)) {
    Gathering behind{tree_->surfaces(), FarBehind(path.data(), path.size()), from, 0.0, 0.0,
                     crossings};
    tree_->Search(behind.from, behind.to, Gather, &behind);
    for (const Crossing& crossing : crossings) Turn(crossing, buffers);
    crossings.clear();
  }
  for (std::size_t n = 1; n < path.size(); ++n) {
    const Place to = PlaceOf(path[n].place_mm);
    Gathering piece{tree_->surfaces(),           from,     to, path[n - 1].at,
                    path[n].at - path[n - 1].at, crossings};
    tree_->Search(from, to, Gather, &piece);
    from = to;
  }
  std::ranges::sort(crossings, [](const Crossing& a, const Crossing& b) {
    if (a.at != b.at) return a.at < b.at;
    return a.surface != b.surface ? a.surface < b.surface : a.turn < b.turn;
  });
  out.clear();
  out.push_back({path[0].at, LabelInside(buffers)});
  for (const Crossing& crossing : crossings) {
    Turn(crossing, buffers);
    const volume::Label label = LabelInside(buffers);
    if (out.back().at == crossing.at) {
      out.back().label = label;
    } else if (out.back().label != label) {
      out.push_back({crossing.at, label});
    }
  }
}

}  // namespace acus::tracing
