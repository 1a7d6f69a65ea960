// Where rays meet surfaces: triangles drawn into bands of an image, all layers of them kept.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <span>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/cut_planes.h"
#include "acus/imaging/volume_rendering/shading.h"
#include "acus/imaging/volume_rendering/shadow_map.h"

namespace acus::volume_rendering {

/// What a surface looks like in an image.
struct Drawing {
  const Eigen::Matrix3Xf* nodes_mm = nullptr;  ///< CT space, of the world.
  const Eigen::Matrix3Xf* normals = nullptr;   ///< Of the nodes; null: seen flat, not lit.
  const Eigen::Matrix3Xi* triangles = nullptr;
  Eigen::Array3f colour = Eigen::Array3f::Ones();
  float opacity = 1.0F;    ///< Seen straight on; a thin skin hides more seen from its side.
  bool closed = true;      ///< Only faces towards the camera are drawn.
  bool is_tool = false;    ///< May shine through tissue.
  bool in_shadow = false;  ///< Tools throw their shadow on it.
  /// Nodes and normals are those at rest: a device moves them with the tissue.
  bool at_rest = false;
  /// Grey values over the surface: texture_at.col(node) are column and row. May be null.
  const image::GrayImage* texture = nullptr;
  const Eigen::Matrix2Xf* texture_at = nullptr;
  std::span<const CutPlane> cuts = {};  ///< What they cut away is not drawn.

  bool throws_shadow() const { return is_tool && normals != nullptr; }
};

/// A ray through a surface.
struct Fragment {
  float distance_mm = 0.0F;  ///< From the eye.
  float opacity = 0.0F;
  Eigen::Array3f colour = Eigen::Array3f::Zero();  ///< Lit, not weighted by opacity.
  bool is_tool = false;
  int next = -1;  ///< Of the same pixel, in the order drawn.
};

/// All triangles of an image, sorted into bands of rows.
class TriangleBands {
 public:
  static constexpr int kRows = 8;

  /// Sorts the triangles. The order within a band is that of drawings and triangles, with any
  /// number of threads. `drawings` must stay until the next call.
  void Sort(const Camera& camera, std::span<const Drawing> drawings, int num_threads);
  int num_bands() const { return num_bands_; }

  /// Fragments of one band: opaque ones only where nothing opaque is before them.
  struct Band {
    std::vector<Fragment> fragments;
    std::vector<int> first;   ///< By pixel of the band: into fragments, or -1.
    std::vector<int> opaque;  ///< The nearest opaque one, or -1.
  };
  void Draw(int band, const Light& light, const ShadowMap* shadows, Band& out) const;
  /// Adds those of one pixel of a band by rising distance, none after an opaque one.
  static void Append(const Band& band, std::size_t pixel, std::vector<Fragment>& out);

 private:
  struct Item {
    std::uint32_t drawing;
    std::uint32_t triangle;
  };
  void SortPiece(std::size_t piece, int first, int end);
  void DrawTriangle(const Item& item, int band, const Light& light, const ShadowMap* shadows,
                    Band& out) const;

  Camera camera_;
  std::span<const Drawing> drawings_;
  std::vector<int> first_of_drawing_;
  int num_bands_ = 0;
  std::vector<std::vector<std::vector<Item>>> pieces_;  ///< [piece][band].
};

}  // namespace acus::volume_rendering
