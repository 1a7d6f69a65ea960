#include "acus/window/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace acus::window {
namespace {

/// Smaller motions are invisible.
constexpr double kSamePlacePx = 0.25;
constexpr std::uint8_t kVisible = 8;
/// Images of the window have priority; it shows the last overlay meanwhile.
constexpr int kOverlayNice = 5;

struct Job {
  volume_rendering::Camera camera;
  std::optional<breathing::MotionMap> motion;
};

bool SameMotion(const breathing::MotionWeights& a, const breathing::MotionWeights& b) {
  constexpr double kSameWeight = 0.005;
  if (a.count != b.count) return false;
  for (int i = 0; i < a.count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    if (a.component[n] != b.component[n] || std::abs(a.weight[n] - b.weight[n]) > kSameWeight) {
      return false;
    }
  }
  return true;
}

/// Divides by the opacity, over black, and applies the fading.
void Compose(const volume_rendering::ViewImage& image, const std::vector<float>& distance_px,
             double falloff_px, std::vector<std::uint8_t>& rgba) {
  const std::size_t count = image.coverage.size();
  rgba.resize(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const int cover = image.coverage[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const int weighted = image.colour.rgb[3 * i + k];
      rgba[4 * i + k] =
          static_cast<std::uint8_t>(cover == 0 ? 0 : std::min(255, weighted * 255 / cover));
    }
    const double edge = EdgeOpacity(static_cast<double>(distance_px[i]), falloff_px);
    rgba[4 * i + 3] = static_cast<std::uint8_t>(std::lround(cover * edge));
  }
}

}  // namespace

double EdgeOpacity(double distance_px, double falloff_px) noexcept {
  if (!(falloff_px > 0.0)) return distance_px > 0.0 ? 1.0 : 0.0;
  const double t = std::clamp(distance_px / falloff_px, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

std::vector<float> DistanceToEdge(const std::vector<std::uint8_t>& inside, int width, int height) {
  std::vector<float> out(inside.size(), 0.0F);
  if (inside.empty()) return out;
  // OpenCV defines no distance for an image without an outside.
  if (std::ranges::find(inside, 0) == inside.end()) {
    std::ranges::fill(out, std::numeric_limits<float>::infinity());
    return out;
  }
  const cv::Mat mask(height, width, CV_8UC1, const_cast<std::uint8_t*>(inside.data()));
  cv::Mat distance(height, width, CV_32FC1, out.data());
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  return out;
}

std::vector<std::uint8_t> SilhouetteOf(const mesh::Surface& surface,
                                       const volume_rendering::Camera& camera) {
  std::vector<std::uint8_t> out(
      static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px), 0);
  constexpr double kNearMm = 1.0;
  constexpr int kFraction = 4;  // Fractional bits of a pixel.
  constexpr double kFarPx = 1e4;
  cv::Mat mask(camera.height_px, camera.width_px, CV_8UC1, out.data());
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    std::array<cv::Point, 3> corners;
    bool seen = true;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d node = surface.nodes_mm.col(surface.triangles(i, t));
      if ((camera.camera_from_ct * node)[2] < kNearMm) {
        seen = false;
        break;
      }
      const Eigen::Vector2d pixel = camera.ProjectPx(node);
      seen = seen && pixel.allFinite() && pixel.cwiseAbs().maxCoeff() < kFarPx;
      if (!seen) break;
      corners[static_cast<std::size_t>(i)] = {
          static_cast<int>(std::lround(pixel[0] * (1 << kFraction))),
          static_cast<int>(std::lround(pixel[1] * (1 << kFraction)))};
    }
    if (seen) cv::fillConvexPoly(mask, corners.data(), 3, cv::Scalar(255), cv::LINE_8, kFraction);
  }
  return out;
}

volume_rendering::Camera Resampled(const volume_rendering::Camera& camera, int width_px,
                                   int height_px) {
  volume_rendering::Camera out = camera;
  out.width_px = width_px;
  out.height_px = height_px;
  const Eigen::Array2d factor(static_cast<double>(width_px) / camera.width_px,
                              static_cast<double>(height_px) / camera.height_px);
  out.focal_px = (camera.focal_px.array() * factor).matrix();
  out.centre_px = ((camera.centre_px.array() + 0.5) * factor - 0.5).matrix();
  return out;
}

double LargestShiftPx(const volume_rendering::Camera& from, const volume_rendering::Camera& to,
                      const Eigen::AlignedBox3d& box_in_ct_mm) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (box_in_ct_mm.isEmpty()) return 0.0;
  double largest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d place =
        box_in_ct_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if ((from.camera_from_ct * place)[2] < 1.0 || (to.camera_from_ct * place)[2] < 1.0) {
      return kNever;
    }
    const double shift = (from.ProjectPx(place) - to.ProjectPx(place)).norm();
    largest = std::isfinite(shift) ? std::max(largest, shift) : kNever;
  }
  return largest;
}

struct OverlayRenderer::Content {
  volume_rendering::PatientView view;
  mesh::Surface outline;
  OverlaySettings settings;

  std::mutex mutex;
  std::condition_variable changed;
  std::optional<Job> job;  ///< Waiting or being rendered.
  std::optional<OverlayImage> done;
  std::optional<Job> newest;  ///< The job of the newest overlay.
  long num_rendered = 0;
  std::exception_ptr error;  ///< Error of the thread, thrown by the next call.
  bool stop = false;
  std::thread thread;

  Content(const volume_rendering::PatientInView& patient,
          const volume_rendering::ViewSettings& look)
      : view(patient, look) {}

  OverlayImage Render(const Job& wanted) {
    OverlayImage out;
    const auto size = [&](int video_px) {
      return std::max(1, static_cast<int>(std::lround(settings.scale * video_px)));
    };
    out.camera =
        Resampled(wanted.camera, size(wanted.camera.width_px), size(wanted.camera.height_px));
    volume_rendering::ViewImage image;
    volume_rendering::ViewMoment moment;
    moment.motion = wanted.motion ? &*wanted.motion : nullptr;
    view.Render(out.camera, moment, image, 1);
    std::vector<std::uint8_t> inside;
    if (outline.triangles.cols() > 0) {
      inside = SilhouetteOf(outline, out.camera);
    } else {
      inside = image.coverage;
      for (std::uint8_t& pixel : inside) pixel = pixel >= kVisible ? 255 : 0;
    }
    Compose(image, DistanceToEdge(inside, out.camera.width_px, out.camera.height_px),
            settings.falloff_share * out.camera.width_px, out.rgba);
    return out;
  }

  void Finish(OverlayImage&& image) {
    done = std::move(image);
    newest = job;
    job.reset();
    ++num_rendered;
  }

  void Work() {
    const auto thread_id = static_cast<id_t>(gettid());
    setpriority(PRIO_PROCESS, thread_id, getpriority(PRIO_PROCESS, thread_id) + kOverlayNice);
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stop || job; });
      if (stop) return;
      const Job wanted = *job;
      lock.unlock();
      OverlayImage image;
      std::exception_ptr thrown;
      try {
        image = Render(wanted);
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      if (thrown) {
        error = thrown;
        job.reset();
      } else {
        Finish(std::move(image));
      }
      changed.notify_all();
    }
  }
};

OverlayRenderer::OverlayRenderer(const volume_rendering::PatientInView& patient,
                                 const mesh::Surface* outline, const OverlaySettings& settings) {
  volume_rendering::ViewSettings look;
  look.tool_shadows = false;
  look.background_top.setZero();
  look.background_bottom.setZero();
  content_ = std::make_unique<Content>(patient, look);
  if (outline != nullptr) content_->outline = *outline;
  content_->settings = settings;
  if (settings.in_background) content_->thread = std::thread([this] { content_->Work(); });
}

OverlayRenderer::~OverlayRenderer() {
  {
    const std::lock_guard lock(content_->mutex);
    content_->stop = true;
  }
  content_->changed.notify_all();
  if (content_->thread.joinable()) content_->thread.join();
}

void OverlayRenderer::Ask(const volume_rendering::Camera& video,
                          const breathing::MotionMap* motion) {
  Content& c = *content_;
  const std::lock_guard lock(c.mutex);
  if (c.error) std::rethrow_exception(std::exchange(c.error, nullptr));
  if (c.job) return;
  const breathing::MotionWeights at_rest;
  const auto weights = [&](const auto* map) { return map == nullptr ? at_rest : map->weights(); };
  if (c.newest && c.newest->camera.width_px == video.width_px &&
      c.newest->camera.height_px == video.height_px &&
      LargestShiftPx(c.newest->camera, video, c.view.box_in_ct_mm()) < kSamePlacePx &&
      SameMotion(weights(c.newest->motion ? &*c.newest->motion : nullptr), weights(motion))) {
    return;
  }
  c.job.emplace(Job{.camera = video, .motion = std::nullopt});
  if (motion != nullptr && motion->moves()) c.job->motion.emplace(*motion);
  if (c.thread.joinable()) {
    c.changed.notify_all();
  } else {
    c.Finish(c.Render(*c.job));
  }
}

bool OverlayRenderer::Take(OverlayImage& out) {
  const std::lock_guard lock(content_->mutex);
  if (!content_->done) return false;
  out = std::move(*content_->done);
  content_->done.reset();
  return true;
}

void OverlayRenderer::Wait() {
  std::unique_lock lock(content_->mutex);
  content_->changed.wait(lock, [&] { return !content_->job; });
}

const Eigen::AlignedBox3d& OverlayRenderer::box_in_ct_mm() const {
  return content_->view.box_in_ct_mm();
}

long OverlayRenderer::num_rendered() const {
  const std::lock_guard lock(content_->mutex);
  return content_->num_rendered;
}

}  // namespace acus::window
