#include "acus/imaging/slicing/tracing/triangle_tree.h"

#include <algorithm>
#include <atomic>
#include <embree3/rtcore.h>
#include <limits>
#include <string>

#include "acus/base/core/error.h"

namespace acus::tracing {
namespace {

/// Boxes are larger by this, units: rays are rounded to float, by less than one unit per
/// coordinate within the box around all triangles.
constexpr float kBoxMargin = 4.0F;

/// A search: Embree hands it on to what is called for each box.
struct SearchContext {
  RTCIntersectContext context;  ///< First, so that a pointer to it is one to the search.
  TriangleTree::Visit visit;
  void* visited;
};

void BoundsOfTriangle(const RTCBoundsFunctionArguments* args) {
  const auto& surface = *static_cast<const TreeSurface*>(args->geometryUserPtr);
  float low[3];
  float high[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](int corner) {
      return static_cast<float>(surface.nodes(axis, surface.triangles(corner, args->primID)));
    };
    low[axis] = std::min({at(0), at(1), at(2)}) - kBoxMargin;
    high[axis] = std::max({at(0), at(1), at(2)}) + kBoxMargin;
  }
  *args->bounds_o = {low[0], low[1], low[2], 0.0F, high[0], high[1], high[2], 0.0F};
}

/// Nothing is ever hit: the search ends when all boxes along the segment have been visited.
void VisitTriangle(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const auto& search = *reinterpret_cast<const SearchContext*>(args->context);
  search.visit(search.visited, args->geomID, args->primID);
}

}  // namespace

struct TriangleTree::Embree {
  explicit Embree(int num_threads)
      : device(rtcNewDevice(("threads=" + std::to_string(std::max(1, num_threads))).c_str())) {
    ACUS_REQUIRE(device != nullptr, "surfaces as triangles: Embree cannot start");
    rtcSetDeviceMemoryMonitorFunction(device, CountBytes, this);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  }
  ~Embree() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  static bool CountBytes(void* self, ssize_t bytes, bool /*after*/) {
    static_cast<Embree*>(self)->num_bytes += bytes;
    return true;
  }

  void Attach(TreeSurface& surface) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(surface.triangles.cols()));
    rtcSetGeometryUserData(geometry, &surface);
    rtcSetGeometryBoundsFunction(
        geometry, [](const RTCBoundsFunctionArguments* args) { BoundsOfTriangle(args); }, nullptr);
    rtcSetGeometryOccludedFunction(geometry, VisitTriangle);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  std::atomic<std::ptrdiff_t> num_bytes{0};
  RTCDevice device;
  RTCScene scene = nullptr;
};

TriangleTree::TriangleTree(std::vector<TreeSurface> surfaces, int num_threads)
    : surfaces_(std::move(surfaces)), embree_(std::make_unique<Embree>(num_threads)) {
  ACUS_REQUIRE(num_triangles() > 0, "surfaces as triangles: there is no triangle");
  low_.fill(std::numeric_limits<double>::max());
  high_.fill(std::numeric_limits<double>::lowest());
  for (TreeSurface& surface : surfaces_) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto row = surface.nodes.row(axis);
      low_[a] = std::min(low_[a], static_cast<double>(row.minCoeff()) - kBoxMargin);
      high_[a] = std::max(high_[a], static_cast<double>(row.maxCoeff()) + kBoxMargin);
    }
    embree_->Attach(surface);
  }
  rtcCommitScene(embree_->scene);
  const RTCError error = rtcGetDeviceError(embree_->device);
  ACUS_REQUIRE(error == RTC_ERROR_NONE, "surfaces as triangles: no hierarchy of ", num_triangles(),
               " triangles could be built (",
               error == RTC_ERROR_OUT_OF_MEMORY ? "out of memory; use fewer triangles"
                                                : "error of Embree " + std::to_string(error),
               ")");
}

TriangleTree::~TriangleTree() = default;

std::size_t TriangleTree::num_triangles() const {
  std::size_t sum = 0;
  for (const TreeSurface& surface : surfaces_) {
    sum += static_cast<std::size_t>(surface.triangles.cols());
  }
  return sum;
}

std::size_t TriangleTree::memory_bytes() const {
  auto sum = static_cast<std::size_t>(embree_->num_bytes.load());
  for (const TreeSurface& surface : surfaces_) {
    sum += static_cast<std::size_t>(surface.nodes.size() + surface.triangles.size()) *
           sizeof(std::int32_t);
  }
  return sum;
}

bool TriangleTree::IsOutside(const Place& place) const noexcept {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto at = static_cast<double>(place[a]);
    if (at < low_[a] || at > high_[a]) return true;
  }
  return false;
}

void TriangleTree::Search(const Place& from, const Place& to, Visit visit,
                          void* context) const noexcept {
  // Only the part within the box, so that floats are fine enough.
  double begin = 0.0;
  double end = 1.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto at = static_cast<double>(from[a]);
    const auto step = static_cast<double>(to[a] - from[a]);
    if (step == 0.0) {
      if (at < low_[a] || at > high_[a]) return;
      continue;
    }
    const double first = (low_[a] - at) / step;
    const double second = (high_[a] - at) / step;
    begin = std::max(begin, std::min(first, second));
    end = std::min(end, std::max(first, second));
  }
  if (begin > end) return;
  RTCRay ray{};
  float* const origin[3] = {&ray.org_x, &ray.org_y, &ray.org_z};
  float* const direction[3] = {&ray.dir_x, &ray.dir_y, &ray.dir_z};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto at = static_cast<double>(from[a]);
    const auto step = static_cast<double>(to[a] - from[a]);
    *origin[a] = static_cast<float>(at + begin * step);
    *direction[a] = static_cast<float>((end - begin) * step);
  }
  ray.tfar = 1.0F;
  ray.mask = ~0U;
  SearchContext search{{}, visit, context};
  rtcInitIntersectContext(&search.context);
  rtcOccluded1(embree_->scene, &search.context, &ray);
}

}  // namespace acus::tracing
