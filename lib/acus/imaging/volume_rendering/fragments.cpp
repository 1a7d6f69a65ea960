#include "acus/imaging/volume_rendering/fragments.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr int kPieces = 16;
constexpr double kNearMm = 1.0;

/// A triangle as the camera sees it. Olano & Greer 1997: with M = [v0 v1 v2] in the camera's frame,
/// weights.transpose() * direction = M^-1 direction are the barycentric numbers over the depth.
struct SeenTriangle {
  Eigen::Matrix3d weights;  ///< Column i: of corner i, for a direction with z = 1.
  Eigen::Array2i low_px;    ///< Columns and rows with their centre inside the bounds.
  Eigen::Array2i high_px;
  bool seen = false;
};

SeenTriangle See(const Camera& camera, const Eigen::Matrix3d& camera_from_ct,
                 const Eigen::Vector3d& eye_mm, const Drawing& drawing, int triangle) {
  SeenTriangle out;
  Eigen::Matrix3d at;
  for (int n = 0; n < 3; ++n) {
    const int node = (*drawing.triangles)(n, triangle);
    at.col(n) = camera_from_ct * (drawing.nodes_mm->col(node).cast<double>() - eye_mm);
  }
  if (at.row(2).maxCoeff() < kNearMm) return out;
  out.low_px.setZero();
  out.high_px = {camera.width_px - 1, camera.height_px - 1};
  if (at.row(2).minCoeff() >= kNearMm) {
    const Eigen::Array<double, 2, 3> px =
        ((at.topRows<2>().array().rowwise() / at.row(2).array()).colwise() *
         camera.focal_px.array())
            .colwise() +
        camera.centre_px.array();
    const Eigen::Array2d low = px.rowwise().minCoeff().ceil().max(0.0);
    const Eigen::Array2d high = px.rowwise().maxCoeff().floor().min(out.high_px.cast<double>());
    if ((low > high).any()) return out;
    out.low_px = low.cast<int>();
    out.high_px = high.cast<int>();
  }
  Eigen::Matrix3d edges;
  edges.col(0) = at.col(1).cross(at.col(2));
  edges.col(1) = at.col(2).cross(at.col(0));
  edges.col(2) = at.col(0).cross(at.col(1));
  const double determinant = at.col(0).dot(edges.col(0));
  // Counter-clockwise seen from outside: negative towards the camera.
  if (determinant == 0.0 || (drawing.closed && determinant > 0.0)) return out;
  out.weights = edges / determinant;
  out.seen = true;
  return out;
}

/// On a shared edge, one of the two triangles has the pixel.
bool Inside(double share, const Eigen::Vector3d& weight) {
  if (share != 0.0) return share > 0.0;
  return weight[0] > 0.0 || (weight[0] == 0.0 && weight[1] > 0.0);
}

float GreyAt(const image::GrayImage& image, const Eigen::Vector2f& at) {
  const float column = std::clamp(at[0], 0.0F, static_cast<float>(image.width - 1));
  const float row = std::clamp(at[1], 0.0F, static_cast<float>(image.height - 1));
  const int c = std::min(static_cast<int>(column), std::max(0, image.width - 2));
  const int r = std::min(static_cast<int>(row), std::max(0, image.height - 2));
  const int c1 = std::min(c + 1, image.width - 1);
  const int r1 = std::min(r + 1, image.height - 1);
  const float fc = column - static_cast<float>(c);
  const float fr = row - static_cast<float>(r);
  const auto grey = [&](int i, int j) { return static_cast<float>(image.At(i, j)); };
  const float top = grey(c, r) + fc * (grey(c1, r) - grey(c, r));
  const float bottom = grey(c, r1) + fc * (grey(c1, r1) - grey(c, r1));
  return (top + fr * (bottom - top)) / 255.0F;
}

/// Colour and opacity where a ray meets a triangle.
void Paint(const Drawing& drawing, int triangle, const Eigen::Vector3f& shares,
           const Eigen::Vector3f& place_mm, const Eigen::Vector3f& to_eye, const Light& light,
           const ShadowMap* shadows, Fragment& out) {
  const auto corners = drawing.triangles->col(triangle);
  out.opacity = drawing.opacity;
  out.colour = drawing.colour;
  out.is_tool = drawing.is_tool;
  if (drawing.texture != nullptr) {
    Eigen::Vector2f at = Eigen::Vector2f::Zero();
    for (int n = 0; n < 3; ++n) at += shares[n] * drawing.texture_at->col(corners[n]);
    out.colour *= GreyAt(*drawing.texture, at);
  }
  if (drawing.normals == nullptr) return;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  for (int n = 0; n < 3; ++n) normal += shares[n] * drawing.normals->col(corners[n]);
  normal.normalize();
  const float lit = shadows != nullptr && drawing.in_shadow ? shadows->LitAt(place_mm) : 1.0F;
  out.colour = Shade(light, out.colour, normal, to_eye, lit);
  if (drawing.opacity < 1.0F) {
    const float way = 1.0F / std::max(0.25F, std::abs(normal.dot(to_eye)));
    out.opacity = 1.0F - std::pow(1.0F - drawing.opacity, way);
  }
}

}  // namespace

void TriangleBands::SortPiece(std::size_t piece, int first, int end) {
  auto& bands = pieces_[piece];
  bands.resize(static_cast<std::size_t>(num_bands_));
  for (auto& band : bands) band.clear();
  std::size_t drawing = 0;
  const Eigen::Matrix3d turn = camera_.camera_from_ct.linear();
  const Eigen::Vector3d eye_mm = camera_.EyeInCtMm();
  for (int t = first; t < end; ++t) {
    while (t >= first_of_drawing_[drawing + 1]) ++drawing;
    const int triangle = t - first_of_drawing_[drawing];
    const SeenTriangle seen = See(camera_, turn, eye_mm, drawings_[drawing], triangle);
    if (!seen.seen) continue;
    for (int band = seen.low_px[1] / kRows; band <= seen.high_px[1] / kRows; ++band) {
      bands[static_cast<std::size_t>(band)].push_back(
          {static_cast<std::uint32_t>(drawing), static_cast<std::uint32_t>(triangle)});
    }
  }
}

void TriangleBands::Sort(const Camera& camera, std::span<const Drawing> drawings, int num_threads) {
  camera_ = camera;
  drawings_ = drawings;
  num_bands_ = (camera.height_px + kRows - 1) / kRows;
  first_of_drawing_.assign(1, 0);
  for (const Drawing& drawing : drawings) {
    first_of_drawing_.push_back(first_of_drawing_.back() +
                                static_cast<int>(drawing.triangles->cols()));
  }
  const int count = first_of_drawing_.back();
  pieces_.resize(kPieces);
  ParallelFor(kPieces, num_threads, [&](int piece) {
    const auto at = [&](int n) {
      return static_cast<int>(static_cast<std::int64_t>(count) * n / kPieces);
    };
    SortPiece(static_cast<std::size_t>(piece), at(piece), at(piece + 1));
  });
}

void TriangleBands::DrawTriangle(const Item& item, int band, const Light& light,
                                 const ShadowMap* shadows, Band& out) const {
  const Drawing& drawing = drawings_[item.drawing];
  const auto triangle = static_cast<int>(item.triangle);
  const Eigen::Matrix3d turn = camera_.camera_from_ct.linear();
  const Eigen::Vector3d eye_mm = camera_.EyeInCtMm();
  const SeenTriangle seen = See(camera_, turn, eye_mm, drawing, triangle);
  const int top = band * kRows;
  for (int row = std::max(top, seen.low_px[1]); row <= std::min(top + kRows - 1, seen.high_px[1]);
       ++row) {
    for (int column = seen.low_px[0]; column <= seen.high_px[0]; ++column) {
      const Eigen::Vector3d direction((column - camera_.centre_px[0]) / camera_.focal_px[0],
                                      (row - camera_.centre_px[1]) / camera_.focal_px[1], 1.0);
      const Eigen::Vector3d over_depth = seen.weights.transpose() * direction;
      if (!(Inside(over_depth[0], seen.weights.col(0)) &&
            Inside(over_depth[1], seen.weights.col(1)) &&
            Inside(over_depth[2], seen.weights.col(2)))) {
        continue;
      }
      const double depth_mm = 1.0 / over_depth.sum();
      if (!(depth_mm >= kNearMm)) continue;
      if (!drawing.cuts.empty() &&
          IsCutAway(drawing.cuts, eye_mm + depth_mm * (turn.transpose() * direction))) {
        continue;
      }
      const auto distance_mm = static_cast<float>(depth_mm * direction.norm());
      const auto pixel =
          static_cast<std::size_t>(row - top) * static_cast<std::size_t>(camera_.width_px) +
          static_cast<std::size_t>(column);
      int& opaque = out.opaque[pixel];
      if (opaque >= 0 &&
          out.fragments[static_cast<std::size_t>(opaque)].distance_mm <= distance_mm) {
        continue;
      }
      Fragment fragment;
      fragment.distance_mm = distance_mm;
      const Eigen::Vector3f ray = (turn.transpose() * direction).normalized().cast<float>();
      Paint(drawing, triangle, (over_depth * depth_mm).cast<float>(),
            eye_mm.cast<float>() + distance_mm * ray, -ray, light, shadows, fragment);
      const auto number = static_cast<int>(out.fragments.size());
      if (drawing.opacity >= 1.0F) {
        // One of these is enough, and its place is used again.
        if (opaque >= 0) {
          out.fragments[static_cast<std::size_t>(opaque)] = fragment;
          continue;
        }
        opaque = number;
      } else {
        fragment.next = out.first[pixel];
        out.first[pixel] = number;
      }
      out.fragments.push_back(fragment);
    }
  }
}

void TriangleBands::Draw(int band, const Light& light, const ShadowMap* shadows, Band& out) const {
  const auto pixels = static_cast<std::size_t>(kRows) * static_cast<std::size_t>(camera_.width_px);
  out.fragments.clear();
  out.first.assign(pixels, -1);
  out.opaque.assign(pixels, -1);
  for (const auto& piece : pieces_) {
    for (const Item& item : piece[static_cast<std::size_t>(band)]) {
      DrawTriangle(item, band, light, shadows, out);
    }
  }
}

void TriangleBands::Append(const Band& band, std::size_t pixel, std::vector<Fragment>& out) {
  const auto begin = static_cast<std::ptrdiff_t>(out.size());
  if (const int n = band.opaque[pixel]; n >= 0) {
    out.push_back(band.fragments[static_cast<std::size_t>(n)]);
  }
  for (int n = band.first[pixel]; n >= 0; n = band.fragments[static_cast<std::size_t>(n)].next) {
    out.push_back(band.fragments[static_cast<std::size_t>(n)]);
  }
  std::stable_sort(out.begin() + begin, out.end(), [](const Fragment& a, const Fragment& b) {
    return a.distance_mm < b.distance_mm;
  });
  const auto opaque = std::find_if(out.begin() + begin, out.end(),
                                   [](const Fragment& f) { return f.opacity >= 1.0F; });
  if (opaque != out.end()) out.erase(opaque + 1, out.end());
}

}  // namespace acus::volume_rendering
