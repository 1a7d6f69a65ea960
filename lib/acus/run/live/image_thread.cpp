#include "acus/run/live/image_thread.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/run/live/image_bounds.h"

namespace acus::live {

struct ImageThread::Renderers {
  /// Of an effect of the list.
  struct OfEffect {
    OfEffect(const simulation::Scene& scene, const simulation::ListedEffect& effect)
        : renderer(scene, effect, RunContext()) {
      const double rate_hz = effect.timing.rate_hz;
      if (rate_hz > 0.0) interval_ns = std::llround(1e9 / rate_hz);
    }
    simulation::EffectImageRenderer renderer;
    std::int64_t interval_ns = 0;  ///< 0: with all images.
    std::int64_t due_ns = 0;
    std::optional<LiveSnapshot> shown;
  };

  explicit Renderers(const simulation::Scene& of_scene) : scene(of_scene) {
    if (scene.probe) probe = std::make_shared<const acoustics::Probe>(*scene.probe);
    images.emplace(scene, probe.get());
    for (const simulation::ListedEffect& effect : scene.listed.all()) {
      if (effect.has_image && effect.timing.is_live) effects.emplace_back(scene, effect);
    }
  }
  const simulation::Scene& scene;
  std::shared_ptr<const acoustics::Probe> probe;
  std::optional<double> gain_db;  ///< As it was asked for last.
  std::optional<double> depth_mm;
  std::optional<simulation::ProbeImageRenderer> images;
  std::deque<OfEffect> effects;
};

double ImageStatistics::per_s() const {
  const double span_s = 1e-9 * static_cast<double>(last_ns - first_ns);
  return span_s > 0.0 ? static_cast<double>(images - 1) / span_s : 0.0;
}

nlohmann::json ImageStatistics::ToJson() const {
  return {{"images", images.load()},
          {"late", late.load()},
          {"failed", failed.load()},
          {"per_s", per_s()},
          {"render", render.ToJson()},
          {"interval", interval.ToJson()},
          {"tracker_to_image", tracker_to_image.ToJson()}};
}

ImageThread::ImageThread(const simulation::Scene& scene, TripleBuffer<LiveSnapshot>& snapshots,
                         double rate_hz, std::function<void(const LiveImage&)> on_image)
    : snapshots_(snapshots),
      rate_hz_(rate_hz),
      on_image_(std::move(on_image)),
      renderers_(std::make_unique<Renderers>(scene)) {
  for (const auto& effect : renderers_->effects) {
    const simulation::ListedEffect& of = effect.renderer.effect();
    last_effects_.push_back({of.key, of.title, {}});
  }
}

ImageThread::~ImageThread() {
  Stop();
}

void ImageThread::Start() {
  thread_ = std::thread([this] { Run(); });
}

void ImageThread::Stop() noexcept {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void ImageThread::Run() {
  const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / rate_hz_));
  std::int64_t due_ns = MonotonicNs();
  while (!stopping_) {
    const std::int64_t begin_ns = MonotonicNs();
    if (begin_ns < due_ns) {
      std::this_thread::sleep_for(
          std::chrono::nanoseconds(std::min<std::int64_t>(due_ns - begin_ns, 20'000'000)));
      continue;
    }
    due_ns += period_ns;
    while (due_ns <= begin_ns) {
      due_ns += period_ns;
      ++statistics_.late;
    }
    if (!snapshots_.Refresh()) continue;  // Before the first step, or the device is silent.
    try {
      MakeImage(begin_ns);
      SetTrouble("");
    } catch (const std::bad_alloc&) {
      SetTrouble("there is no memory for images; close other programs");
    } catch (const std::exception& error) {
      SetTrouble(error.what());
    }
  }
}

void ImageThread::MakeImage(std::int64_t begin_ns) {
  LiveImage& out = images_.Back();
  Render(out);
  const std::int64_t end_ns = MonotonicNs();
  statistics_.render.Add(end_ns - begin_ns);
  const bool is_first = statistics_.images == 0;
  if (is_first) statistics_.first_ns = end_ns;
  if (!is_first) statistics_.interval.Add(end_ns - statistics_.last_ns);
  statistics_.last_ns = end_ns;
  statistics_.tracker_to_image.Add(end_ns - out.snapshot.measured_ns);
  ++statistics_.images;
  if (on_image_) on_image_(out);
  images_.Publish();
}

void ImageThread::SetTrouble(const char* what) {
  const bool failed = *what != '\0';
  if (failed) {
    ++statistics_.failed;
    shown_.reset();  // Half of it may be of one moment, half of another.
  }
  const std::lock_guard lock(trouble_mutex_);
  if (failed || !trouble_.empty()) trouble_ = what;
}

std::string ImageThread::trouble() const {
  const std::lock_guard lock(trouble_mutex_);
  return trouble_;
}

void ImageThread::SetProbe(const LiveSnapshot& snapshot) {
  Renderers& r = *renderers_;
  if (!r.probe || (snapshot.gain_db == r.gain_db && snapshot.depth_mm == r.depth_mm)) return;
  r.gain_db = snapshot.gain_db;
  r.depth_mm = snapshot.depth_mm;
  shown_.reset();
  auto probe = std::make_shared<acoustics::Probe>(*r.scene.probe);
  probe->gain_db = std::clamp(r.gain_db.value_or(probe->gain_db), -kLargestGainDb, kLargestGainDb);
  probe->depth_mm =
      std::clamp(r.depth_mm.value_or(probe->depth_mm), kLeastDepthMm, kLargestDepthMm);
  try {
    acoustics::CheckedProbe(*probe);
    r.images.emplace(r.scene, probe.get());
    r.probe = std::move(probe);
  } catch (const InputError&) {
    r.images.emplace(r.scene, r.probe.get());  // What this probe cannot do is left undone.
  }
}

void ImageThread::Render(LiveImage& out) {
  out.snapshot = snapshots_.Front();
  out.number = ++number_;
  const simulation::Snapshot moment = out.snapshot.ForRenderer();
  if (!out.snapshot.frozen) {
    SetProbe(out.snapshot);
    std::optional<simulation::Snapshot> shown;
    if (shown_) shown = shown_->ForRenderer();
    renderers_->images->Render(moment, last_images_, &stage_times_, shown ? &*shown : nullptr);
    shown_ = out.snapshot;
    for (std::size_t n = 0; n < renderers_->effects.size(); ++n) {
      auto& effect = renderers_->effects[n];
      if (moment.time_ns < effect.due_ns) continue;
      shown.reset();
      if (effect.shown) shown = effect.shown->ForRenderer();
      effect.renderer.Render(moment, &last_images_, last_effects_[n].pixels, &stage_times_,
                             shown ? &*shown : nullptr);
      effect.shown = out.snapshot;
      effect.due_ns = moment.time_ns + effect.interval_ns;
    }
  }
  out.probe = renderers_->probe;
  out.images = last_images_;
  out.effects = last_effects_;
}

}  // namespace acus::live
