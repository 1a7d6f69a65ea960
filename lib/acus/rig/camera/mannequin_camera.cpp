#include "acus/rig/camera/mannequin_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/rig/camera/canvas.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

/// Normal numbers, long enough that no row of an image meets the same ones at the same place.
constexpr std::size_t kNoiseLength = 1U << 16;

std::vector<float> NoiseTile(double sigma) {
  std::vector<float> tile(kNoiseLength + 3 * 8192);
  RandomStream random(/*seed=*/0, "camera noise tile");
  for (float& value : tile) value = static_cast<float>(sigma * random.Normal());
  return tile;
}

const ImageMaking& Checked(const ImageMaking& m) {
  ACUS_REQUIRE(m.samples >= 1 && m.samples <= 16, "mannequin camera: ", m.samples,
               " samples; allowed is 1 to 16");
  ACUS_REQUIRE(m.blur_sigma_px >= 0.0 && m.blur_sigma_px <= 20.0, "mannequin camera: a blur of ",
               m.blur_sigma_px, " px; allowed is 0 to 20");
  ACUS_REQUIRE(m.noise_sigma >= 0.0 && m.noise_sigma <= 100.0, "mannequin camera: noise of ",
               m.noise_sigma, " grey levels; allowed is 0 to 100");
  ACUS_REQUIRE(m.black >= 0.0 && m.black < m.white && m.white <= 255.0, "mannequin camera: black ",
               m.black, " and white ", m.white, "; allowed is 0 <= black < white <= 255");
  ACUS_REQUIRE(std::abs(m.light_gradient) <= 1.0, "mannequin camera: a light gradient of ",
               m.light_gradient, "; allowed is -1 to 1");
  return m;
}

}  // namespace

struct MannequinCamera::Content {
  CameraModel camera;
  FacetSet facets;
  ImageMaking making;
  RayTable rays;
  std::vector<std::pair<std::string, ShadedBody>> bodies;  ///< With the object that carries each.
  std::vector<std::vector<PrintedSheet>> prints;           ///< By object, by marker.
  std::vector<float> noise;
  Canvas canvas;

  void PaintBackground() {
    // A table's edge to edge grey that darkens downwards: nothing to be mistaken for a marker.
    for (int row = 0; row < canvas.height_px; ++row) {
      const float level =
          120.0F - 40.0F * static_cast<float>(row) / static_cast<float>(canvas.height_px);
      const std::size_t width = static_cast<std::size_t>(canvas.width_px * canvas.channels);
      std::fill_n(canvas.level.begin() + static_cast<std::ptrdiff_t>(row * width), width, level);
    }
  }

  void PaintObjects(std::span<const ObjectInView> objects) {
    struct Job {
      double z_mm;
      const PrintedSheet* print;
      Eigen::Isometry3d pose;
    };
    std::vector<Job> jobs;
    for (const ObjectInView& object : objects) {
      const FacetObject* found = facets.Find(object.name);
      ACUS_REQUIRE(found != nullptr, "object '", object.name, "' is not in the facet set '",
                   facets.name, "'");
      ACUS_REQUIRE(object.camera_from_object.matrix().allFinite(), "the pose of '", object.name,
                   "' is not finite");
      for (const auto& [carrier, body] : bodies) {
        if (carrier == object.name) PaintBody(body, object.camera_from_object, camera, canvas);
      }
      const auto number = static_cast<std::size_t>(found - facets.objects.data());
      for (std::size_t m = 0; m < found->markers.size(); ++m) {
        const Eigen::Isometry3d pose =
            object.camera_from_object * found->markers[m].object_from_marker;
        jobs.push_back({pose.translation()[2], &prints[number][m], pose});
      }
    }
    std::stable_sort(jobs.begin(), jobs.end(),
                     [](const Job& a, const Job& b) { return a.z_mm > b.z_mm; });
    const Ink ink{static_cast<float>(making.black), static_cast<float>(making.white),
                  making.samples};
    for (const Job& job : jobs) PaintSheet(*job.print, job.pose, ink, camera, rays, canvas);
  }

  void Expose(std::uint64_t noise_index, Image& out) {
    const int values = canvas.width_px * canvas.channels;
    cv::Mat levels(canvas.height_px, canvas.width_px, CV_32FC(canvas.channels),
                   canvas.level.data());
    for (int row = 0; row < canvas.height_px; ++row) {
      float* level = levels.ptr<float>(row);
      for (int i = 0; i < values; ++i) {
        const int column = i / canvas.channels;
        level[i] *= static_cast<float>(
            1.0 + making.light_gradient * (static_cast<double>(column) / canvas.width_px - 0.5));
      }
    }
    if (making.blur_sigma_px > 0.0) {
      cv::GaussianBlur(levels, levels, {0, 0}, making.blur_sigma_px, making.blur_sigma_px,
                       cv::BORDER_REPLICATE);
    }
    out.Resize(canvas.width_px, canvas.height_px, canvas.channels);
    for (int row = 0; row < canvas.height_px; ++row) {
      RandomStream random(noise_index, "camera noise", static_cast<std::uint64_t>(row));
      const float* noise_row = noise.data() + random.Next() % kNoiseLength;
      const float* level = levels.ptr<float>(row);
      std::uint8_t* to = out.pixels.data() + static_cast<std::ptrdiff_t>(row) * values;
      for (int i = 0; i < values; ++i) {
        to[i] = static_cast<std::uint8_t>(std::clamp(level[i] + noise_row[i] + 0.5F, 0.0F, 255.0F));
      }
    }
  }
};

mesh::Surface PlainTorso() {
  constexpr int kAround = 64;
  constexpr int kAlong = 48;
  const Eigen::Vector3d half_mm(170.0, 250.0, 110.0);
  mesh::Surface torso;
  torso.nodes_mm.resize(3, kAround * (kAlong + 1));
  torso.triangles.resize(3, 2 * kAround * kAlong);
  // A superellipsoid with y as its axis: flatter than an ellipsoid, as a trunk is.
  const auto power = [](double value) {
    return std::copysign(std::pow(std::abs(value), 0.7), value);
  };
  for (int j = 0; j <= kAlong; ++j) {
    const double v = std::numbers::pi * (static_cast<double>(j) / kAlong - 0.5);
    for (int i = 0; i < kAround; ++i) {
      const double u = 2.0 * std::numbers::pi * i / kAround;
      const double ring = power(std::cos(v));
      torso.nodes_mm.col(j * kAround + i) =
          half_mm.cwiseProduct(Eigen::Vector3d(ring * power(std::cos(u)), power(std::sin(v)),
                                               ring * power(std::sin(u)))) -
          Eigen::Vector3d(0, 0, half_mm[2]);
    }
  }
  Eigen::Index t = 0;
  for (int j = 0; j < kAlong; ++j) {
    for (int i = 0; i < kAround; ++i) {
      const int a = j * kAround + i;
      const int b = j * kAround + (i + 1) % kAround;
      torso.triangles.col(t++) << a, a + kAround, b;
      torso.triangles.col(t++) << b, a + kAround, b + kAround;
    }
  }
  return torso;
}

MannequinCamera::MannequinCamera(const CameraModel& camera, FacetSet facets,
                                 std::vector<BodyInView> bodies, const ImageMaking& making)
    : content_(new Content{.camera = camera,
                           .facets = std::move(facets),
                           .making = Checked(making),
                           .rays = RayTable(camera),
                           .bodies = {},
                           .prints = {},
                           .noise = NoiseTile(making.noise_sigma),
                           .canvas = {}}) {
  HoldOpenCvToOneThread();
  for (const BodyInView& body : bodies) {
    ACUS_REQUIRE(content_->facets.Find(body.object) != nullptr, "a body is carried by '",
                 body.object, "', which is not in the facet set '", content_->facets.name, "'");
    content_->bodies.emplace_back(body.object, PrepareBody(body.surface, body.colour));
  }
  for (const FacetObject& object : content_->facets.objects) {
    std::vector<PrintedSheet>& prints = content_->prints.emplace_back();
    for (const Marker& marker : object.markers) {
      prints.push_back(PrintMarker(content_->facets.dictionary, marker.id, marker.side_mm));
    }
  }
}

MannequinCamera::~MannequinCamera() = default;
MannequinCamera::MannequinCamera(MannequinCamera&&) noexcept = default;
MannequinCamera& MannequinCamera::operator=(MannequinCamera&&) noexcept = default;

void MannequinCamera::Render(std::span<const ObjectInView> objects, std::uint64_t noise_index,
                             Image& out) {
  const CameraParameters& p = content_->camera.parameters();
  content_->canvas.Resize(p.width_px, p.height_px, content_->making.colour ? 3 : 1);
  content_->PaintBackground();
  content_->PaintObjects(objects);
  content_->Expose(noise_index, out);
}

void RenderBoard(const CameraModel& camera, const CalibrationBoard& board,
                 const Eigen::Isometry3d& camera_from_board, const ImageMaking& making,
                 std::uint64_t noise_index, Image& out) {
  MannequinCamera::Content content{.camera = camera,
                                   .facets = {},
                                   .making = Checked(making),
                                   .rays = RayTable(camera),
                                   .bodies = {},
                                   .prints = {},
                                   .noise = NoiseTile(making.noise_sigma),
                                   .canvas = {}};
  const CameraParameters& p = camera.parameters();
  content.canvas.Resize(p.width_px, p.height_px, making.colour ? 3 : 1);
  content.PaintBackground();
  const PrintedSheet sheet{
      .module_mm = board.ModuleMm(), .margin_mm = 0.4 * board.square_mm, .bits = board.Modules()};
  const Ink ink{static_cast<float>(making.black), static_cast<float>(making.white), making.samples};
  PaintSheet(sheet, camera_from_board, ink, camera, content.rays, content.canvas);
  content.Expose(noise_index, out);
}

}  // namespace acus::camera
