#include "acus/patient/meshing/mesh_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acus/data/volume/labels.h"

namespace acus::meshing {
namespace {

using nlohmann::json;

constexpr double kPanelPx = 440.0;
constexpr double kMarginPx = 24.0;

std::string Colour(std::uint8_t label) {
  const auto c = volume::ColourOf(label);
  return Message("rgb(", int{c[0]}, ",", int{c[1]}, ",", int{c[2]}, ")");
}

double Rounded(double value) {
  return std::round(value * 10.0) / 10.0;
}

/// The polygon in which the plane x[axis] = at cuts a tetrahedron: 0, 3 or 4 corners in order.
std::vector<Eigen::Vector3d> CutPolygon(const mesh::Corners& x, int axis, double at_mm) {
  std::vector<int> below;
  std::vector<int> above;
  for (int c = 0; c < 4; ++c) (x[c][axis] < at_mm ? below : above).push_back(c);
  std::vector<Eigen::Vector3d> out;
  const auto cut = [&](int a, int b) {
    const double share = (at_mm - x[a][axis]) / (x[b][axis] - x[a][axis]);
    out.push_back(x[a] + share * (x[b] - x[a]));
  };
  if (below.size() == 2) {
    cut(below[0], above[0]);
    cut(below[0], above[1]);
    cut(below[1], above[1]);
    cut(below[1], above[0]);
  } else {
    for (const int b : below) {
      for (const int a : above) cut(b, a);
    }
  }
  return out;
}

/// A square panel with the cut; horizontal and vertical are axes of LPS, `up` turns the vertical.
void DrawCut(std::ostringstream& svg, const mesh::TetraMesh& mesh, int axis, double at_mm,
             double left_px, const char* title) {
  const int across = axis == 0 ? 1 : 0;
  const int down = axis == 2 ? 1 : 2;
  const Eigen::Vector3d low = mesh.nodes_mm.rowwise().minCoeff();
  const Eigen::Vector3d high = mesh.nodes_mm.rowwise().maxCoeff();
  const double extent = std::max(high[across] - low[across], high[down] - low[down]);
  const double scale = kPanelPx / std::max(extent, 1e-9);
  svg << "<g transform=\"translate(" << left_px << "," << 2 * kMarginPx << ")\">\n<text y=\"-8\">"
      << title << " at " << Rounded(at_mm) << " mm</text>\n"
      << "<g stroke=\"#222\" stroke-width=\"0.25\" stroke-linejoin=\"round\">\n";
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const auto polygon = CutPolygon(mesh::CornersOf(mesh, t), axis, at_mm);
    if (polygon.size() < 3) continue;
    svg << "<path fill=\"" << Colour(mesh.tissue[t]) << "\" d=\"M";
    for (const Eigen::Vector3d& p : polygon) {
      // Axial: anterior (-P) on top, as radiologists look. Others: head (+S) on top.
      const double v = down == 1 ? p[down] - low[down] : high[down] - p[down];
      svg << Rounded(scale * (p[across] - low[across])) << " " << Rounded(scale * v) << " ";
    }
    svg << "Z\"/>\n";
  }
  svg << "</g></g>\n";
}

void DrawHistogram(std::ostringstream& svg, const mesh::QualityReport& quality, double limit_deg,
                   double left_px, double top_px) {
  constexpr double kHeight = 150.0;
  const double most =
      static_cast<double>(std::max<Eigen::Index>(1, std::ranges::max(quality.histogram)));
  const double bar = kPanelPx / 36.0;
  svg << "<g transform=\"translate(" << left_px << "," << top_px << ")\">\n<text y=\"-8\">dihedral "
      << "angles [degrees]: smallest " << Rounded(quality.min_dihedral_deg) << ", largest "
      << Rounded(quality.max_dihedral_deg) << "</text>\n";
  for (int b = 0; b < 36; ++b) {
    const double height = kHeight * static_cast<double>(quality.histogram[b]) / most;
    svg << "<rect x=\"" << Rounded(b * bar) << "\" y=\"" << kHeight - height << "\" width=\""
        << bar - 1 << "\" height=\"" << height << "\" fill=\"#4878a8\"/>\n";
  }
  const double x = limit_deg / 180.0 * kPanelPx;
  svg << "<path d=\"M" << x << " 0V" << kHeight
      << "\" stroke=\"#c03028\" stroke-dasharray=\"4 3\"/>\n"
      << "<text x=\"" << x + 4 << "\" y=\"10\" fill=\"#c03028\">limit " << limit_deg << "</text>\n"
      << "<path d=\"M0 " << kHeight << "H" << kPanelPx << "\" stroke=\"#222\"/>\n";
  for (int degrees = 0; degrees <= 180; degrees += 30) {
    svg << "<text text-anchor=\"middle\" x=\"" << degrees / 180.0 * kPanelPx << "\" y=\""
        << kHeight + 16 << "\">" << degrees << "</text>\n";
  }
  svg << "</g>\n";
}

void DrawTable(std::ostringstream& svg, const std::vector<TissueVolume>& tissues, double left_px,
               double top_px) {
  svg << "<g transform=\"translate(" << left_px << "," << top_px << ")\">\n"
      << "<text y=\"-8\">volumes [ml]: label map, mesh, difference</text>\n";
  double y = 8.0;
  for (const TissueVolume& tissue : tissues) {
    svg << "<rect x=\"0\" y=\"" << y << "\" width=\"12\" height=\"12\" stroke=\"#222\" fill=\""
        << Colour(tissue.label) << "\"/><text x=\"20\" y=\"" << y + 10 << "\">" << tissue.name
        << (tissue.is_conforming ? " (own surface)" : "") << "</text>";
    const double percent = 100.0 * (tissue.mesh_ml / tissue.map_ml - 1.0);
    const std::array<std::string, 3> cells = {
        Message(Rounded(tissue.map_ml)), Message(Rounded(tissue.mesh_ml)),
        Message(percent >= 0 ? "+" : "", Rounded(percent), " %")};
    for (int c = 0; c < 3; ++c) {
      svg << "<text text-anchor=\"end\" x=\"" << 250 + 80 * c << "\" y=\"" << y + 10 << "\">"
          << cells[c] << "</text>";
    }
    svg << "\n";
    y += 18.0;
  }
  svg << "</g>\n";
}

}  // namespace

Eigen::Vector3d CentreOf(const mesh::TetraMesh& mesh) {
  return 0.5 * (mesh.nodes_mm.rowwise().minCoeff() + mesh.nodes_mm.rowwise().maxCoeff());
}

json DescribeMesh(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues) {
  const mesh::QualityReport quality = mesh::MeasureQuality(mesh);
  std::array<std::int64_t, 256> elements{};
  for (const std::uint8_t label : mesh.tissue) ++elements[label];
  json out = {
      {"nodes", quality.num_nodes},
      {"fixed_nodes", quality.num_fixed_nodes},
      {"tetrahedra", quality.num_tetrahedra},
      {"inverted_tetrahedra", quality.num_inverted},
      {"min_dihedral_deg", quality.min_dihedral_deg},
      {"max_dihedral_deg", quality.max_dihedral_deg},
      {"mean_min_dihedral_deg", quality.mean_min_dihedral_deg},
      {"max_radius_edge_ratio", quality.max_radius_edge_ratio},
      {"worst_at_mm", {quality.worst_at_mm[0], quality.worst_at_mm[1], quality.worst_at_mm[2]}},
      {"dihedral_histogram", {{"bin_width_deg", 5}, {"counts", quality.histogram}}},
      {"tissues", json::array()}};
  for (const TissueVolume& tissue : tissues) {
    out["tissues"].push_back(
        {{"label", tissue.label},
         {"name", tissue.name},
         {"label_map_ml", tissue.map_ml},
         {"mesh_ml", tissue.mesh_ml},
         {"difference_percent", 100.0 * (tissue.mesh_ml / tissue.map_ml - 1.0)},
         {"tetrahedra", elements[tissue.label]},
         {"has_own_surface", tissue.is_conforming}});
    if (tissue.surface) out["tissues"].back()["surface_distance"] = ToJson(*tissue.surface);
  }
  return out;
}

json ToJson(const SurfaceDistance& distance) {
  // A tissue that the mesh has lost is infinitely far: null.
  const auto known = [](double value) { return std::isfinite(value) ? json(value) : json(); };
  return {{"p95_mm", known(distance.p95_mm)},
          {"p95_voxels", known(distance.p95_voxels)},
          {"mean_mm", known(distance.mean_mm)},
          {"samples", distance.num_samples}};
}

std::string MeshImageSvg(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                         const Eigen::Vector3d& centre_mm, double min_dihedral_deg) {
  const double second = 2 * kMarginPx + kPanelPx;
  const double below = 4 * kMarginPx + kPanelPx;
  const double height = below + std::max(200.0, 30.0 + 18.0 * static_cast<double>(tissues.size()));
  std::ostringstream svg;
  svg.precision(6);
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << second + kPanelPx + kMarginPx
      << " " << height << "\" font-family=\"sans-serif\" font-size=\"12\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  DrawCut(svg, mesh, 2, centre_mm[2], kMarginPx, "axial cut (anterior on top)");
  DrawCut(svg, mesh, 0, centre_mm[0], second, "sagittal cut (head on top, anterior left)");
  DrawHistogram(svg, mesh::MeasureQuality(mesh), min_dihedral_deg, kMarginPx, below);
  DrawTable(svg, tissues, second, below);
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace acus::meshing
