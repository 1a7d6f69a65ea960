// Surfaces and tools of an image, drawn by the rasteriser of a graphics card.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "acus/imaging/graphics/gl_objects.h"
#include "acus/imaging/volume_rendering/ray_device.h"

namespace acus::graphics {

/// Units of textures, and bindings of buffers, of all shaders.
enum Unit : unsigned {
  kHu,
  kSlopes,
  kClasses,
  kDistances,
  kPressed,
  kShadows,
  kFirstComponent,
  kOpaqueColour = 10,
  kOpaqueDistance,
  kGreyImage
};
/// OpenGL guarantees eight: one number means two buffers that no shader has both of.
enum Binding : unsigned {
  kIntegral,
  kValue,
  kCuts,
  kHeads,
  kNodes,
  kPixels,
  kNumNodes = kPixels,
  kColours,
  kCoverage
};

/// Belongs to one context, and to the thread in which that is current.
class SurfacesOnCard {
 public:
  SurfacesOnCard();

  /// Before the others: makes room for an image. @return the number of nodes that lists can have.
  int Begin(const volume_rendering::DeviceImage& image);
  /// Draws everything. MomentBlock, cuts, breath and pressed tissue are bound.
  void Draw(const volume_rendering::DeviceImage& image);
  /// For the shader that casts the rays.
  void Bind() const;
  /// After the rays were cast. @return false if the lists had too few nodes: the image is not
  /// whole, and the
  ///     next Begin() makes room.
  bool HadRoom();

 private:
  struct Piece {
    const Mesh* mesh;
    std::size_t first_corner;
    std::size_t num_corners;
  };
  void PlaceMeshes(std::span<const volume_rendering::Drawing> drawings);
  const Mesh& TissueMesh(const volume_rendering::Drawing& drawing);
  void DrawShadows(std::span<const volume_rendering::Drawing> drawings);
  void DrawPiece(const volume_rendering::Drawing& drawing, const Piece& piece, Program& program);

  Program opaque_;
  Program translucent_;
  Program shadow_;
  Canvas canvas_;
  Canvas shadow_canvas_;
  ImageTexture colour_, distance_, depth_, heights_, grey_;
  Buffer heads_;
  Buffer nodes_;
  Buffer num_nodes_;
  int most_nodes_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  /// Tissue stays on the card, by its triangles; tools are sent with each image.
  std::map<const Eigen::Matrix3Xi*, std::unique_ptr<Mesh>> tissue_;
  Mesh tools_;
  std::vector<MeshVertex> tool_vertices_;
  std::vector<std::uint32_t> tool_corners_;
  std::vector<Piece> pieces_;  ///< By drawing.
};

}  // namespace acus::graphics
