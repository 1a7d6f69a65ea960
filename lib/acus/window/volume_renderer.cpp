#include "acus/window/volume_renderer.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::window {
namespace {

constexpr int kNice = 5;
constexpr std::size_t kTimesKept = 12;
/// Tolerance in shares of full scale; PSNR of at least 41 dB to an image with a ray for each pixel,
/// in 60 to 100 % of its time.
constexpr double kPixelTolerance = 0.01;

volume_rendering::ViewSettings LookOfVolume() {
  volume_rendering::ViewSettings settings;
  settings.rays.pixel_tolerance = kPixelTolerance;
  settings.background_top = settings.background_bottom = {0.09F, 0.11F, 0.13F};
  return settings;
}

volume_rendering::PatientInView WithOpacity(volume_rendering::PatientInView patient,
                                            double opacity) {
  for (auto& layer : patient.layers) layer.opacity *= opacity;
  for (auto& surface : patient.surfaces) surface.opacity *= opacity;
  return patient;
}

bool SameNeedle(const image::NeedleInImage& a, const image::NeedleInImage& b) {
  if (a.tip_in_ct_mm != b.tip_in_ct_mm || a.axis_in_ct != b.axis_in_ct ||
      a.length_mm != b.length_mm || a.shape.num_points != b.shape.num_points) {
    return false;
  }
  for (int i = 0; i < a.shape.num_points; ++i) {
    if (a.shape.At(i) != b.shape.At(i)) return false;
  }
  return true;
}

bool SameBreath(const breathing::MotionWeights& a, const breathing::MotionWeights& b) {
  return a.count == b.count && a.component == b.component && a.weight == b.weight;
}

template <class Value, class Same>
bool SameIfAny(const std::optional<Value>& a, const std::optional<Value>& b, const Same& same) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

}  // namespace

bool VolumeMoment::SameView(const VolumeMoment& other) const {
  const auto same_cut = [](const auto& a, const auto& b) { return a.coeffs() == b.coeffs(); };
  return camera.camera_from_ct.matrix() == other.camera.camera_from_ct.matrix() &&
         look == other.look && opacity == other.opacity &&
         std::ranges::equal(cuts, other.cuts, same_cut);
}

bool VolumeMoment::SameContent(const VolumeMoment& other) const {
  return SameIfAny(
             motion, other.motion,
             [](const auto& a, const auto& b) { return SameBreath(a.weights(), b.weights()); }) &&
         SameIfAny(needle, other.needle, SameNeedle) &&
         SameIfAny(ct_from_probe, other.ct_from_probe,
                   [](const auto& a, const auto& b) { return a.matrix() == b.matrix(); }) &&
         probe == other.probe && b_mode.pixels == other.b_mode.pixels && pressed == other.pressed;
}

struct VolumeRenderer::Content {
  struct Job {
    VolumeMoment moment;
    bool may_stop = false;
  };

  Content(const std::vector<VolumeLook>& all, VolumeRays on) : looks(all), rays(on) {}

  /// Null look: none yet. Used by the rendering thread only.
  const std::vector<VolumeLook>& looks;
  VolumeRays rays;
  std::unique_ptr<volume_rendering::PatientView> view;
  std::size_t view_look = 0;
  double view_opacity = 0.0;
  volume_rendering::ViewImage rendered;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::optional<Job> waiting;
  std::optional<Job> running;
  std::optional<image::ColourImage> done;
  VolumeStatistics counts;
  std::deque<std::int64_t> finished_ns;
  std::string trouble;
  bool stop = false;
  std::thread thread;

  bool Superseded() const {
    const std::lock_guard lock(mutex);
    return stop || (waiting && running->may_stop && !waiting->moment.SameView(running->moment));
  }

  void MakeView(const VolumeMoment& moment) {
    if (view && view_look == moment.look && view_opacity == moment.opacity) return;
    view.reset();
    view = std::make_unique<volume_rendering::PatientView>(
        WithOpacity(looks.at(moment.look).patient, moment.opacity), LookOfVolume());
    view_look = moment.look;
    view_opacity = moment.opacity;
    UseCard();
  }

  /// Without a card, or after its first failure, the processor is used.
  void UseCard() {
    if (rays == VolumeRays::kProcessor) return;
    std::string name, why;
    try {
      auto card = graphics::MakeShaderRays(DriverFor(rays));
      name = card->name();
      view->UseDevice(std::move(card));
    } catch (const InputError& error) {
      if (rays == VolumeRays::kGraphics) why = error.what();
      rays = VolumeRays::kProcessor;
    }
    const std::lock_guard lock(mutex);
    counts.rays_on = name;
    counts.card_trouble = why;
  }
  /// Called after an image.
  void WatchCard() {
    if (view->device_trouble().empty() || rays == VolumeRays::kProcessor) return;
    rays = VolumeRays::kProcessor;
    const std::lock_guard lock(mutex);
    counts.rays_on.clear();
    counts.card_trouble = view->device_trouble();
  }

  /// False if it was stopped.
  bool Render(const Job& job, image::ColourImage& out) {
    const VolumeMoment& moment = job.moment;
    MakeView(moment);
    volume_rendering::ViewMoment seen;
    seen.motion = moment.motion ? &*moment.motion : nullptr;
    seen.needle = moment.needle;
    seen.pressed = moment.pressed.get();
    seen.cuts = moment.cuts;
    if (moment.ct_from_probe && moment.probe) {
      seen.probe.emplace();
      seen.probe->ct_from_probe = *moment.ct_from_probe;
      seen.probe->probe = moment.probe.get();
      if (!moment.b_mode.pixels.empty()) seen.probe->b_mode = &moment.b_mode;
    }
    const std::function<bool()> superseded = [this] { return Superseded(); };
    if (!view->Render(moment.camera, seen, rendered, 1, job.may_stop ? superseded : nullptr)) {
      return false;
    }
    WatchCard();
    std::swap(out, rendered.colour);
    return true;
  }

  /// @pre `running` is set. Never throws: trouble() returns the message of an error.
  void RenderRunning() {
    image::ColourImage image;
    std::string what;
    bool whole = false;
    const double cpu_s = ThreadCpuSeconds();
    try {
      whole = Render(*running, image);
    } catch (const std::exception& error) {
      what = error.what();
      view.reset();
    }
    const std::int64_t now_ns = MonotonicNs();
    const std::lock_guard lock(mutex);
    running.reset();
    trouble = what;
    if (whole) {
      done = std::move(image);
      ++counts.images;
      counts.cpu_ms = 1e3 * (ThreadCpuSeconds() - cpu_s);
      finished_ns.push_back(now_ns);
      if (finished_ns.size() > kTimesKept) finished_ns.pop_front();
    }
  }

  void Work() {
    const auto thread_id = static_cast<id_t>(gettid());
    setpriority(PRIO_PROCESS, thread_id, getpriority(PRIO_PROCESS, thread_id) + kNice);
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stop || waiting; });
      if (stop) return;
      running = std::exchange(waiting, std::nullopt);
      lock.unlock();
      RenderRunning();
      lock.lock();
      changed.notify_all();
    }
  }
};

graphics::DriverKind DriverFor(VolumeRays rays) {
  ACUS_ASSERT(rays != VolumeRays::kProcessor);
  return rays == VolumeRays::kAuto ? graphics::DriverKind::kHardware : graphics::DriverKind::kAny;
}

VolumeRays VolumeRaysOf(std::string_view name) {
  if (name == "auto") return VolumeRays::kAuto;
  if (name == "processor") return VolumeRays::kProcessor;
  ACUS_REQUIRE(name == "graphics", "volume rays on \"", name,
               "\"; allowed are auto, processor and graphics");
  return VolumeRays::kGraphics;
}

VolumeRenderer::VolumeRenderer(const std::vector<VolumeLook>& looks, bool in_background,
                               VolumeRays rays)
    : content_(std::make_unique<Content>(looks, rays)) {
  ACUS_ASSERT(!looks.empty());
  if (in_background) content_->thread = std::thread([this] { content_->Work(); });
}

VolumeRenderer::~VolumeRenderer() {
  {
    const std::lock_guard lock(content_->mutex);
    content_->stop = true;
  }
  content_->changed.notify_all();
  if (content_->thread.joinable()) content_->thread.join();
}

void VolumeRenderer::Ask(VolumeMoment moment, bool may_stop) {
  Content& c = *content_;
  if (!c.thread.joinable()) {
    c.running = Content::Job{std::move(moment), false};
    c.RenderRunning();
    return;
  }
  {
    const std::lock_guard lock(c.mutex);
    if (c.waiting) ++c.counts.dropped;
    c.waiting = Content::Job{std::move(moment), may_stop};
  }
  c.changed.notify_all();
}

bool VolumeRenderer::Take(image::ColourImage& out) {
  const std::lock_guard lock(content_->mutex);
  if (!content_->done) return false;
  out = std::move(*content_->done);
  content_->done.reset();
  return true;
}

bool VolumeRenderer::idle() const {
  const std::lock_guard lock(content_->mutex);
  return !content_->waiting && !content_->running;
}

void VolumeRenderer::Wait() {
  std::unique_lock lock(content_->mutex);
  content_->changed.wait(lock, [&] { return !content_->waiting && !content_->running; });
}

VolumeStatistics VolumeRenderer::statistics() const {
  const std::lock_guard lock(content_->mutex);
  VolumeStatistics out = content_->counts;
  const auto& times = content_->finished_ns;
  if (times.size() >= 2) {
    out.per_s = 1e9 * static_cast<double>(times.size() - 1) /
                static_cast<double>(times.back() - times.front());
  }
  return out;
}

std::string VolumeRenderer::trouble() const {
  const std::lock_guard lock(content_->mutex);
  return content_->trouble;
}

}  // namespace acus::window
