#include "acus/imaging/graphics/surfaces_on_card.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <algorithm>

#include "acus/imaging/graphics/surface_shader.h"

namespace acus::graphics {
namespace {

using volume_rendering::DeviceImage;
using volume_rendering::Drawing;
using volume_rendering::ShadowMap;

constexpr float kFar = 3.0e38F;
/// As in ShadowMap: no tool is there.
constexpr float kNoTool = -1e30F;
/// Lists begin with this many nodes a ray and grow to what an image needs.
constexpr double kNodesPerRay = 0.5;
constexpr std::size_t kNodeBytes = 16;

void Append(const Drawing& drawing, std::vector<MeshVertex>& vertices,
            std::vector<std::uint32_t>& corners) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (Eigen::Index n = 0; n < drawing.nodes_mm->cols(); ++n) {
    MeshVertex vertex{drawing.nodes_mm->col(n), Eigen::Vector3f::UnitZ(), Eigen::Vector2f::Zero()};
    if (drawing.normals != nullptr) vertex.normal = drawing.normals->col(n);
    if (drawing.texture_at != nullptr) vertex.texel = drawing.texture_at->col(n);
    vertices.push_back(vertex);
  }
  const auto* begin = drawing.triangles->data();
  std::transform(begin, begin + drawing.triangles->size(), std::back_inserter(corners),
                 [&](int corner) { return first + static_cast<std::uint32_t>(corner); });
}

}  // namespace

SurfacesOnCard::SurfacesOnCard()
    : opaque_({{ShaderStage::kVertex, SurfaceVertexSource()},
               {ShaderStage::kFragment, OpaqueFragmentSource()}}),
      translucent_({{ShaderStage::kVertex, SurfaceVertexSource()},
                    {ShaderStage::kFragment, TranslucentFragmentSource()}}),
      shadow_({{ShaderStage::kVertex, ShadowVertexSource()},
               {ShaderStage::kFragment, ShadowFragmentSource()}}) {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  // Rows run downwards, which turns the triangles about.
  // Rows run downwards, which turns the triangles about.
  glFrontFace(GL_CW);
  glCullFace(GL_BACK);
  heights_.Resize(PixelFormat::kFloat, ShadowMap::kSize, ShadowMap::kSize);
  shadow_canvas_.Attach({&heights_}, nullptr);
}

int SurfacesOnCard::Begin(const DeviceImage& image) {
  const int width_px = image.camera.width_px;
  const int height_px = image.camera.height_px;
  const double rays = static_cast<double>(width_px) * height_px;
  if (width_px != width_px_ || height_px != height_px_) {
    colour_.Resize(PixelFormat::kHalf4, width_px, height_px);
    distance_.Resize(PixelFormat::kFloat, width_px, height_px);
    depth_.Resize(PixelFormat::kDepth, width_px, height_px);
    canvas_.Attach({&colour_, &distance_}, &depth_);
    width_px_ = width_px;
    height_px_ = height_px;
  }
  most_nodes_ = std::max(most_nodes_, static_cast<int>(kNodesPerRay * rays));
  nodes_.Set(nullptr, kNodeBytes * static_cast<std::size_t>(most_nodes_));
  num_nodes_.Clear(sizeof(std::uint32_t));
  heads_.Clear(static_cast<std::size_t>(rays) * sizeof(std::uint32_t));
  return most_nodes_;
}

const Mesh& SurfacesOnCard::TissueMesh(const Drawing& drawing) {
  std::unique_ptr<Mesh>& mesh = tissue_[drawing.triangles];
  if (!mesh) {
    std::vector<MeshVertex> vertices;
    std::vector<std::uint32_t> corners;
    Append(drawing, vertices, corners);
    mesh = std::make_unique<Mesh>();
    mesh->Set(vertices, corners);
  }
  return *mesh;
}

void SurfacesOnCard::PlaceMeshes(std::span<const Drawing> drawings) {
  pieces_.clear();
  tool_vertices_.clear();
  tool_corners_.clear();
  for (const Drawing& drawing : drawings) {
    const auto num_corners = static_cast<std::size_t>(drawing.triangles->size());
    if (drawing.at_rest) {
      pieces_.push_back({&TissueMesh(drawing), 0, num_corners});
    } else {
      pieces_.push_back({&tools_, tool_corners_.size(), num_corners});
      Append(drawing, tool_vertices_, tool_corners_);
    }
  }
  if (!tool_corners_.empty()) tools_.Set(tool_vertices_, tool_corners_);
}

void SurfacesOnCard::DrawShadows(std::span<const Drawing> drawings) {
  shadow_canvas_.Clear(0, kNoTool);
  shadow_canvas_.Use(ShadowMap::kSize, ShadowMap::kSize);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendEquation(GL_MAX);
  shadow_.Use();
  for (std::size_t n = 0; n < drawings.size(); ++n) {
    if (!drawings[n].throws_shadow()) continue;
    pieces_[n].mesh->Draw(pieces_[n].first_corner, pieces_[n].num_corners);
  }
  glDisable(GL_BLEND);
}

void SurfacesOnCard::DrawPiece(const Drawing& drawing, const Piece& piece, Program& program) {
  Eigen::Vector4f colour;
  colour << drawing.colour.matrix(), drawing.opacity;
  program.Set("surface_colour", colour);
  program.Set("is_tissue", drawing.at_rest ? 1 : 0);
  program.Set("is_lit", drawing.normals != nullptr ? 1 : 0);
  program.Set("is_cut", drawing.cuts.empty() ? 0 : 1);
  program.Set("is_in_shadow", drawing.in_shadow ? 1 : 0);
  program.Set("is_tool", drawing.is_tool ? 1 : 0);
  program.Set("has_grey", drawing.texture != nullptr ? 1 : 0);
  if (drawing.texture != nullptr) {
    grey_.Resize(PixelFormat::kGrey, drawing.texture->width, drawing.texture->height);
    grey_.Write(drawing.texture->pixels.data());
    grey_.Bind(kGreyImage);
  }
  if (drawing.closed) {
    glEnable(GL_CULL_FACE);
  } else {
    glDisable(GL_CULL_FACE);
  }
  piece.mesh->Draw(piece.first_corner, piece.num_corners);
}

void SurfacesOnCard::Draw(const DeviceImage& image) {
  PlaceMeshes(image.drawings);
  if (image.shadows != nullptr) DrawShadows(image.drawings);
  heights_.Bind(kShadows);
  canvas_.Clear(0, 0.0F);
  canvas_.Clear(1, kFar);
  canvas_.ClearDepth(0.0F);
  canvas_.Use(width_px_, height_px_);
  heads_.Bind(kHeads);
  nodes_.Bind(kNodes);
  num_nodes_.Bind(kNumNodes);
  glEnable(GL_DEPTH_TEST);
  for (const bool opaque : {true, false}) {
    Program& program = opaque ? opaque_ : translucent_;
    program.Use();
    const GLboolean writes = opaque ? GL_TRUE : GL_FALSE;
    glDepthMask(writes);
    glColorMask(writes, writes, writes, writes);
    for (std::size_t n = 0; n < image.drawings.size(); ++n) {
      if ((image.drawings[n].opacity >= 1.0F) != opaque) continue;
      DrawPiece(image.drawings[n], pieces_[n], program);
    }
  }
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void SurfacesOnCard::Bind() const {
  heads_.Bind(kHeads);
  nodes_.Bind(kNodes);
  colour_.Bind(kOpaqueColour);
  distance_.Bind(kOpaqueDistance);
  heights_.Bind(kShadows);
}

bool SurfacesOnCard::HadRoom() {
  std::uint32_t needed = 0;
  num_nodes_.Read(&needed, sizeof(needed));
  if (needed <= static_cast<std::uint32_t>(most_nodes_)) return true;
  most_nodes_ = static_cast<int>(needed + needed / 4);
  return false;
}

}  // namespace acus::graphics
