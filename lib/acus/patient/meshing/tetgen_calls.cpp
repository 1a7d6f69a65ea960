#include "acus/patient/meshing/tetgen_calls.h"

#include <cmath>
#include <string>
#include <tetgen.h>

#include "acus/base/core/child_process.h"
#include "acus/base/core/error.h"
#include "acus/data/mesh/packed_mesh.h"

namespace acus::meshing {
namespace {

constexpr double kDelaunayTimeS = 300.0;

void SetPoints(tetgenio& io, const Eigen::Matrix3Xd& points) {
  io.numberofpoints = static_cast<int>(points.cols());
  io.pointlist = new REAL[points.size()];  // tetgenio deletes it.
  std::copy_n(points.data(), points.size(), io.pointlist);
}

void SetTriangles(tetgenio& io, const Eigen::Matrix3Xi& triangles) {
  io.numberoffacets = static_cast<int>(triangles.cols());
  io.facetlist = new tetgenio::facet[triangles.cols()];
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    tetgenio::facet& facet = io.facetlist[t];
    facet.numberofholes = 0;
    facet.holelist = nullptr;
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    std::copy_n(triangles.col(t).data(), 3, facet.polygonlist[0].vertexlist);
  }
}

/// TetGen turns the corners of its tetrahedra the other way round than we do.
std::string Packed(const tetgenio& io) {
  ACUS_REQUIRE(io.numberoftetrahedra > 0, "no tetrahedron");
  std::vector<int> tetrahedra(4 * static_cast<std::size_t>(io.numberoftetrahedra));
  for (std::size_t t = 0; t < tetrahedra.size(); t += 4) {
    const int* corner = io.tetrahedronlist + t;
    const auto at = [&](int c) {
      return Eigen::Map<const Eigen::Vector3d>(io.pointlist + 3 * corner[c]);
    };
    const double volume = (at(1) - at(0)).dot((at(2) - at(0)).cross(at(3) - at(0)));
    std::copy_n(corner, 4, tetrahedra.data() + t);
    if (volume < 0.0) std::swap(tetrahedra[t], tetrahedra[t + 1]);
  }
  core::ByteWriter out(mesh::kPackedOrder);
  out.Array(std::span<const double>(io.pointlist, 3 * static_cast<std::size_t>(io.numberofpoints)));
  out.Array(std::span<const int>(tetrahedra));
  return out.AsString();
}

std::string Call(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xi& triangles,
                 std::string switches) {
  tetgenio in;
  tetgenio out;
  SetPoints(in, points);
  if (triangles.cols() > 0) SetTriangles(in, triangles);
  tetrahedralize(switches.data(), &in, &out);
  return Packed(out);
}

std::string Reason(const core::ChildResult& result) {
  using End = core::ChildResult::End;
  if (result.end == End::kTimedOut) return result.problem;
  if (result.end == End::kCrashed) return "it crashed (" + result.problem + ")";
  if (result.end == End::kThrew) return result.problem;
  if (result.problem == "1") return "it ran out of memory";
  if (result.problem == "3") return "the surface cuts itself";
  if (result.problem == "4") return "the surface has a very small feature";
  if (result.problem == "5") return "two facets of the surface nearly coincide";
  return "internal error " + result.problem;
}

FilledSurface Run(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xi& triangles,
                  const std::string& switches, double time_s, const char* task,
                  const RunContext& context) {
  core::ChildLimits limits;
  limits.time_s = time_s;
  limits.on_wait = [&] { context.Checkpoint(task, 0.5); };
  const core::ChildResult result =
      core::RunInChild([&] { return Call(points, triangles, switches); }, limits);
  if (result.end != core::ChildResult::End::kDone) {
    throw NoAnswerError(Message("TetGen could not fill ", points.cols(), " points and ",
                                triangles.cols(), " triangles: ", Reason(result),
                                "; try larger elements, or smooth and simplify the surface"));
  }
  core::ByteReader in(result.bytes, mesh::kPackedOrder);
  FilledSurface out;
  out.nodes_mm = mesh::TakeColumns<double, 3>(in);
  out.tetrahedra = mesh::TakeColumns<int, 4>(in);
  return out;
}

}  // namespace

Eigen::Matrix4Xi DelaunayTetrahedra(const Eigen::Matrix3Xd& points_mm, const RunContext& context) {
  ACUS_REQUIRE(points_mm.cols() >= 4, "a mesh needs at least 4 points, got ", points_mm.cols());
  return Run(points_mm, {}, "QzJ", kDelaunayTimeS, "tetrahedra", context).tetrahedra;
}

FilledSurface FillSurface(const mesh::Surface& surface, const SurfaceMeshing& settings,
                          const RunContext& context) {
  std::string switches = Message("QzpO4/7q", settings.max_radius_edge_ratio, "/12");
  if (settings.element_size_mm > 0.0) {
    switches += Message("a", std::pow(settings.element_size_mm, 3) / (6.0 * std::sqrt(2.0)));
  }
  return Run(surface.nodes_mm, surface.triangles, switches, settings.time_limit_s,
             "filling the surface", context);
}

}  // namespace acus::meshing
