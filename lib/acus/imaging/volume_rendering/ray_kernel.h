// The inner loop of volume rendering: rays of a tile side by side, in vector instructions chosen at
// run time (Highway).
//
// Each ray does the same IEEE operations in the same order, without fused multiply-add, whichever
// rays run beside it: the same bits on SSE, AVX2 and AVX-512. When a ray ends, the next one of the
// tile takes its lane. Samples are shaded when enough of them have come together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace acus::volume_rendering::kernels {

/// Voxels of 16 bits; each axis has at least two.
struct VoxelGrid {
  const std::int16_t* data = nullptr;
  float last[3] = {};            ///< Highest index along i, j, k.
  std::int32_t row_bytes = 0;    ///< From j to j + 1.
  std::int32_t slice_bytes = 0;  ///< From k to k + 1.
};

/// Bits of HiddenCells.
struct CellBits {
  const std::uint64_t* bits = nullptr;  ///< Null: every sample is looked at.
  float end[3] = {};                    ///< In voxels.
  std::int32_t row_bits = 0;
  std::int32_t rows = 0;  ///< Per slice.
};

/// VisibleBlocks, and the knots of a WarpLattice.
struct BlockGrid {
  const std::uint8_t* distance = nullptr;  ///< 3 more bytes than blocks may be read.
  std::int32_t size[3] = {};
  const std::uint8_t* smooth = nullptr;  ///< By block; null: none is.
  const float* knots = nullptr;          ///< Four for each corner of a block, in voxels.
};

/// TransferFunction: kCount times four floats.
struct EmissionTable {
  const float* integral = nullptr;
  const float* value = nullptr;
  float lowest_hu = 0.0F;
  std::int32_t count = 0;
  /// Class of each voxel, one table after the other; null: all are of the first.
  const std::uint8_t* classes = nullptr;
};

/// Light of one image, see shading.h.
struct Lamp {
  float to_lamp[3] = {};
  float ambient = 0.0F;
  float diffuse = 0.0F;
  float fill = 0.0F;
  float gloss = 0.0F;
};

/// All that is the same for the rays of an image. Matrices by rows.
struct RayScene {
  VoxelGrid ct;
  const std::int8_t* slopes = nullptr;  ///< Of SlopeVolume, of the same size.
  float slope_unit = 0.0F;              ///< HU/mm of one unit of `slopes`.
  CellBits hidden;
  BlockGrid blocks;
  EmissionTable emission;
  Lamp lamp;
  float forward[3] = {};  ///< Direction of a ray: forward + column * right + row * down.
  float right[3] = {};
  float down[3] = {};
  float index_from_ct[9] = {};  ///< Linear part.
  float blocks_from_ct[9] = {};
  float eye_in_index[3] = {};
  float eye_in_blocks[3] = {};
  float ct_from_slope[9] = {};  ///< Slopes along the axes of the grid into CT space.
  float surface_hu_per_mm = 0.0F;
  float step_mm = 0.0F;
  float dark = 0.0F;        ///< A ray of which no more than this gets through has ended.
  bool is_maximum = false;  ///< Only the largest value is sought ...
  float enough_hu = 0.0F;   ///< ... or one that is no less than this.
  bool moves = false;
  bool has_shadows = false;
};

/// Rays of one image side by side. In: all above colour. Rows are aligned to 64 bytes.
struct RayTile {
  static constexpr int kRays = 128;
  int count = 0;
  float empty_mm = 0.0F;            ///< Nothing shows before that.
  alignas(64) float column[kRays];  ///< In pixels from where `forward` points.
  alignas(64) float row[kRays];
  alignas(64) float end_mm[kRays];        ///< Something opaque is there.
  alignas(64) float fragment_mm[kRays];   ///< The first surface; kNone: there is none.
  alignas(64) float colour[3][kRays];     ///< Of the volume, weighted by opacity.
  alignas(64) float passing[kRays];       ///< Light that gets through.
  alignas(64) float highest_hu[kRays];    ///< If it is sought.
  alignas(64) float direction[3][kRays];  ///< Unit, CT space.
  static constexpr float kNone = std::numeric_limits<float>::max();
};

/// What few samples need, one at a time.
class RayHost {
 public:
  virtual ~RayHost() = default;
  /// Where tissue at this sample was at rest, in voxels, in a block that is not smooth.
  virtual void RestIndex(int ray, int sample, float index[3]) = 0;
  /// A piece of the ray with extinction, and the surfaces on it.
  /// @param passing      Changed by both.
  /// @param fragment_mm  The next surface.
  /// @return the weight of the volume's colour.
  virtual float Absorb(int ray, float extinction_per_mm, float from_mm, float to_mm, float& passing,
                       float& fragment_mm) = 0;
  /// 1 in the light, 0 in a tool's shadow.
  virtual float LitAt(int ray, float at_mm) = 0;
};

/// Marches all rays of a tile to their ends.
void CastRays(const RayScene& scene, RayTile& tile, RayHost& host);

}  // namespace acus::volume_rendering::kernels
