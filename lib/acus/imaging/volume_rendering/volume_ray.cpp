#include "acus/imaging/volume_rendering/volume_ray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "acus/imaging/volume_rendering/surface_mix.h"

namespace acus::volume_rendering {
namespace {

constexpr float kOutsideHu = -1024.0F;

}  // namespace

/// The state of one ray.
struct RayCaster::March {
  Eigen::Vector3d direction;
  Eigen::Vector3f index_step;  ///< Along the ray, per mm.
  Eigen::Vector3f blocks_step;
  SurfaceMix surfaces;
  float end_mm = std::numeric_limits<float>::max();  ///< Something opaque is there.
  RayColour out;
  float passing = 1.0F;  ///< Light that gets through so far.
  float highest_hu = kOutsideHu;

  bool has_before = false;
  bool hidden_before = false;  ///< The sample before needed no voxel: hu_before is not known.
  float hu_before = kOutsideHu;
  Eigen::Vector3f index_before;
  std::optional<WarpedRay> warped;
  void Jump() {
    has_before = hidden_before = false;
    if (warped) warped->Jump();
  }
};

RayCaster::RayCaster(const VolumeScene& scene, const RaySettings& settings,
                     const Eigen::Vector3d& eye_mm)
    : scene_(scene), settings_(settings), eye_mm_(eye_mm) {
  if (scene.motion != nullptr && !scene.motion->moves()) scene_.motion = nullptr;
  if (scene.ct == nullptr) return;
  const Eigen::Affine3d index_from_ct = scene.ct->geometry.index_from_ct();
  index_from_ct_ = index_from_ct.cast<float>();
  last_index_ = (scene.ct->geometry.size - 1).cast<float>();
  eye_in_index_ = (index_from_ct * eye_mm).cast<float>();
  eye_in_blocks_ = scene.blocks->blocks_from_ct() * eye_mm.cast<float>();
}

float RayCaster::HuAt(const volume::CtVolume& ct, const Eigen::Vector3f& index) const noexcept {
  if (!((index.array() >= 0.0F).all() && (index.array() <= last_index_).all())) return kOutsideHu;
  const volume::Geometry& grid = ct.geometry;
  const int i = std::min(static_cast<int>(index[0]), grid.size[0] - 2);
  const int j = std::min(static_cast<int>(index[1]), grid.size[1] - 2);
  const int k = std::min(static_cast<int>(index[2]), grid.size[2] - 2);
  const float fi = index[0] - static_cast<float>(i);
  const float fj = index[1] - static_cast<float>(j);
  const float fk = index[2] - static_cast<float>(k);
  const auto row = static_cast<std::ptrdiff_t>(grid.size[0]);
  const std::ptrdiff_t slice = row * grid.size[1];
  const std::int16_t* corner = ct.voxels.data() + grid.Index(i, j, k);
  const auto along = [fi](const std::int16_t* at) {
    const auto low = static_cast<float>(at[0]);
    return low + fi * (static_cast<float>(at[1]) - low);
  };
  const float near_low = along(corner);
  const float near = near_low + fj * (along(corner + row) - near_low);
  const float far_low = along(corner + slice);
  const float far = far_low + fj * (along(corner + slice + row) - far_low);
  return near + fk * (far - near);
}

Eigen::Vector3f RayCaster::GradientAt(const Eigen::Vector3f& index) const noexcept {
  const Eigen::Vector3f inside = index.cwiseMin(last_index_.matrix()).cwiseMax(0.0F);
  return scene_.ct->geometry.direction.cast<float>() * scene_.slopes->At(inside);
}

Eigen::Array3f RayCaster::ColourAt(const March& march, const Eigen::Array3f& colour,
                                   const Eigen::Vector3f& index, float distance_mm) const {
  const Light& light = scene_.light;
  Eigen::Vector3f slope = GradientAt(index);
  if (scene_.pressed != nullptr) {
    const Eigen::Vector3f place_mm =
        eye_mm_.cast<float>() + distance_mm * march.direction.cast<float>();
    if (scene_.pressed->Contains(place_mm)) {
      slope = scene_.pressed->GradientAt(place_mm).transpose() * slope;
    }
  }
  const float steepness = slope.norm();
  const Eigen::Array3f flat = (light.ambient + 0.5F * (light.diffuse + light.fill)) * colour;
  if (!(steepness > 0.0F)) return flat;
  const Eigen::Vector3f ray = march.direction.cast<float>();
  const float lit = scene_.shadows == nullptr
                        ? 1.0F
                        : scene_.shadows->LitAt(eye_mm_.cast<float>() + distance_mm * ray);
  const Eigen::Array3f shaded = Shade(light, colour, slope / steepness, -ray, lit);
  return flat + std::min(1.0F, steepness / kSurfaceHuPerMm) * (shaded - flat);
}

void RayCaster::Absorb(March& march, const TransferFunction::Emission& emission, float from_mm,
                       float to_mm, const Eigen::Vector3f& index) const {
  if (!(emission[3] > 0.0F)) return;
  const Eigen::Array3f colour = ColourAt(march, emission.head<3>() / emission[3], index, to_mm);
  march.out.colour += march.surfaces.Absorb(emission[3], from_mm, to_mm, march.passing) * colour;
}

/// The first sample out of the cube of empty blocks around this one.
int RayCaster::NextVisible(const March& march, int sample, const Eigen::Vector3f& in_blocks,
                           const Eigen::Array3i& block, int distance) const {
  float exit_mm = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {
    const float step = march.blocks_step[axis];
    if (step == 0.0F) continue;
    const int wall = step > 0.0F ? block[axis] + distance : block[axis] - distance + 1;
    exit_mm = std::min(exit_mm, (static_cast<float>(wall) - in_blocks[axis]) / step);
  }
  const auto steps = static_cast<int>(exit_mm / static_cast<float>(settings_.step_mm));
  return sample + std::max(1, steps);
}

Eigen::Vector3f RayCaster::RestIndex(March& march, int sample, const Eigen::Vector3f& in_blocks,
                                     const Eigen::Array3i& block) const {
  const double distance_mm = sample * settings_.step_mm;
  if (scene_.pressed != nullptr) {
    const Eigen::Vector3f place_mm = (eye_mm_ + distance_mm * march.direction).cast<float>();
    if (scene_.pressed->Contains(place_mm)) return PressedIndex(march, place_mm);
  }
  const Eigen::Vector3f straight =
      eye_in_index_ + static_cast<float>(distance_mm) * march.index_step;
  if (!march.warped) return straight;
  if (scene_.lattice != nullptr && scene_.lattice->IsSmooth(block)) {
    march.warped->Jump();
    return straight + scene_.lattice->OffsetAt(block, in_blocks);
  }
  const Eigen::Vector3d rest_mm = march.warped->RestOf(eye_mm_ + distance_mm * march.direction,
                                                       settings_.step_mm * march.direction);
  return index_from_ct_ * rest_mm.cast<float>();
}

/// First to where breath alone would have the tissue, from there to rest.
Eigen::Vector3f RayCaster::PressedIndex(March& march, const Eigen::Vector3f& place_mm) const {
  const Eigen::Vector3f breathed_mm = place_mm + scene_.pressed->OffsetMm(place_mm);
  if (!march.warped) return index_from_ct_ * breathed_mm;
  march.warped->Jump();
  if (scene_.lattice != nullptr) {
    const Eigen::Vector3f in_blocks = scene_.blocks->blocks_from_ct() * breathed_mm;
    const Eigen::Array3i block = in_blocks.array().floor().cast<int>();
    if ((block >= 0).all() && (block < scene_.blocks->size()).all() &&
        scene_.lattice->IsSmooth(block)) {
      return index_from_ct_ * breathed_mm + scene_.lattice->OffsetAt(block, in_blocks);
    }
  }
  const Eigen::Vector3d rest_mm =
      march.warped->RestOf(breathed_mm.cast<double>(), Eigen::Vector3d::Zero());
  march.warped->Jump();
  return index_from_ct_ * rest_mm.cast<float>();
}

void RayCaster::CastVolume(March& march, float empty_mm) const {
  const VisibleBlocks& blocks = *scene_.blocks;
  // Where the ray is within the blocks at all.
  float enter_mm = empty_mm;
  float leave_mm = march.end_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const float step = march.blocks_step[axis];
    const auto end = static_cast<float>(blocks.size()[axis]);
    const float a = -eye_in_blocks_[axis] / step;
    const float b = (end - eye_in_blocks_[axis]) / step;
    if (step == 0.0F) {
      if (eye_in_blocks_[axis] < 0.0F || eye_in_blocks_[axis] >= end) return;
      continue;
    }
    enter_mm = std::max(enter_mm, std::min(a, b));
    leave_mm = std::min(leave_mm, std::max(a, b));
  }
  if (!scene_.cuts.empty()) {
    const ShownPart part = ShownPartOf(scene_.cuts, eye_mm_, march.direction);
    enter_mm = std::max(enter_mm, static_cast<float>(part.near_mm));
    leave_mm = std::min(leave_mm, static_cast<float>(part.far_mm));
  }
  if (enter_mm < leave_mm) Step(march, enter_mm, leave_mm);
}

/// From sample to sample until nothing more can show.
void RayCaster::Step(March& march, float enter_mm, float leave_mm) const {
  const VisibleBlocks& blocks = *scene_.blocks;
  const auto step_mm = static_cast<float>(settings_.step_mm);
  const bool is_maximum = settings_.projection == Projection::kMaximum;
  const float enough_hu =
      is_maximum ? static_cast<float>(settings_.window.high_hu) : std::numeric_limits<float>::max();
  // Pieces of a ray need a sample beyond either end. A maximum takes none from there: it would be
  // behind an opaque surface, or cut away.
  const float first = is_maximum ? std::ceil(enter_mm / step_mm) : enter_mm / step_mm;
  const float last = is_maximum ? leave_mm / step_mm : std::ceil(leave_mm / step_mm);
  for (int n = static_cast<int>(first);
       n <= static_cast<int>(last) && march.passing > kDark && march.highest_hu < enough_hu;) {
    const float at_mm = static_cast<float>(n) * step_mm;
    const Eigen::Vector3f in_blocks = eye_in_blocks_ + at_mm * march.blocks_step;
    const Eigen::Array3i block = in_blocks.array().cast<int>();  // Towards zero.
    if ((in_blocks.array() < 0.0F).any() || (block >= blocks.size()).any()) {
      march.Jump();
      ++n;
      continue;
    }
    if (const int distance = blocks.DistanceOf(block); distance > 0) {
      march.Jump();
      n = NextVisible(march, n, in_blocks, block, distance);
      continue;
    }
    const Eigen::Vector3f index = RestIndex(march, n, in_blocks, block);
    if (is_maximum) {
      TakeMaximum(march, index);
    } else {
      TakeSample(march, index, at_mm);
    }
    ++n;
  }
}

void RayCaster::TakeMaximum(March& march, const Eigen::Vector3f& index) const {
  if (scene_.hidden != nullptr && scene_.hidden->Hides(index)) return;
  march.highest_hu = std::max(march.highest_hu, HuAt(*scene_.ct, index));
}

/// Where labels have classes, those of the voxels around the place have their shares in it.
TransferFunction::Emission RayCaster::EmissionAt(const Eigen::Vector3f& index, float hu_before,
                                                 float hu) const noexcept {
  if (scene_.classes == nullptr || scene_.classes->data() == nullptr) {
    return scene_.transfer->Between(hu_before, hu);
  }
  const volume::Geometry& grid = scene_.ct->geometry;
  const Eigen::Array3f inside = index.array().min(last_index_).max(0.0F);
  const Eigen::Array3i cell = inside.cast<int>().min(grid.size - 2);
  const Eigen::Array3f share = inside - cell.cast<float>();
  TransferFunction::Emission sum = TransferFunction::Emission::Zero();
  for (int n = 0; n < 8; ++n) {
    const Eigen::Array3i at(n & 1, (n >> 1) & 1, n >> 2);
    const Eigen::Array3i voxel = cell + at;
    const int tissue_class = scene_.classes->data()[grid.Index(voxel[0], voxel[1], voxel[2])];
    sum += (at == 1).select(share, 1.0F - share).prod() *
           scene_.transfer->Between(hu_before, hu, tissue_class);
  }
  return sum;
}

/// What is between the sample before and this one. Between two that are hidden nothing is.
void RayCaster::TakeSample(March& march, const Eigen::Vector3f& index, float at_mm) const {
  const bool hidden = scene_.hidden != nullptr && scene_.hidden->Hides(index);
  if (hidden && (march.hidden_before || !march.has_before)) {
    march.has_before = march.hidden_before = true;
    march.index_before = index;
    return;
  }
  const float hu = HuAt(*scene_.ct, index);
  if (march.has_before) {
    if (march.hidden_before) march.hu_before = HuAt(*scene_.ct, march.index_before);
    const float before_mm = at_mm - static_cast<float>(settings_.step_mm);
    Absorb(march, EmissionAt(index, march.hu_before, hu), before_mm, at_mm, index);
  }
  march.has_before = true;
  march.hidden_before = hidden;
  march.hu_before = hu;
  march.index_before = index;
}

float RayCaster::EmptyUntilMm(const Eigen::Vector3d& middle,
                              std::span<const Eigen::Vector3d> rim) const {
  if (scene_.ct == nullptr || scene_.blocks->nothing_visible()) return kFarMm;
  const VisibleBlocks& blocks = *scene_.blocks;
  const Eigen::Matrix3f& turn = blocks.blocks_from_ct().linear();
  const Eigen::Vector3f step = turn * middle.cast<float>();
  float spread = 0.0F;
  for (const Eigen::Vector3d& ray : rim) {
    const Eigen::Vector3f aside = turn * (ray - middle).cast<float>();
    spread = std::max(spread, 1.02F * aside.cwiseAbs().maxCoeff());
  }
  const float speed = step.cwiseAbs().maxCoeff() + spread;
  const Eigen::Array3f last = blocks.size().cast<float>() - 1e-3F;
  float at_mm = 0.0F;
  while (at_mm < kFarMm) {
    const Eigen::Array3f place = (eye_in_blocks_ + at_mm * step).array();
    const Eigen::Array3f inside = place.max(0.0F).min(last);
    const float outside = (place - inside).abs().maxCoeff();
    // All that is nearer than this, in the sense of the largest coordinate, is empty; so is all
    // beyond the blocks.
    const auto distance = static_cast<float>(blocks.DistanceOf(inside.cast<int>()));
    const float empty = std::max(outside, distance - 1.0F - outside);
    const float way_mm = (empty - spread * at_mm) / speed;
    if (!(way_mm > static_cast<float>(settings_.step_mm))) break;
    at_mm += way_mm;
  }
  if (at_mm >= kFarMm) return kFarMm;
  return std::max(0.0F, at_mm - static_cast<float>(settings_.step_mm));
}

RayColour RayCaster::Cast(const Eigen::Vector3d& direction, std::span<const Fragment> fragments,
                          float empty_mm) const {
  March march;
  march.direction = direction;
  march.surfaces = SurfaceMix(fragments, static_cast<float>(settings_.tool_shine));
  if (!fragments.empty() && fragments.back().opacity >= 1.0F) {
    march.end_mm = fragments.back().distance_mm;
  }
  if (scene_.ct != nullptr && !scene_.blocks->nothing_visible()) {
    march.index_step = index_from_ct_.linear() * direction.cast<float>();
    march.blocks_step = scene_.blocks->blocks_from_ct().linear() * direction.cast<float>();
    if (scene_.motion != nullptr) march.warped.emplace(*scene_.motion, settings_.warp);
    CastVolume(march, empty_mm);
  }
  if (settings_.projection == Projection::kMaximum) {
    march.out.colour +=
        march.surfaces.Cover(OpacityIn(settings_.window, march.highest_hu), march.passing);
  }
  march.surfaces.Pass(std::numeric_limits<float>::max(), march.passing);
  march.out.opacity = 1.0F - march.passing;
  march.surfaces.Finish(march.out.colour, march.out.opacity);
  return march.out;
}

}  // namespace acus::volume_rendering
