#include "acus/run/live/image_maker.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/run/live/image_bounds.h"

namespace acus::live {
namespace {

constexpr std::int64_t kRoundingNs = 1000;  // Tolerance of times on a grid.

}  // namespace

struct ImageMaker::Renderers {
  /// The renderer of an effect of the list.
  struct OfEffect {
    OfEffect(const simulation::Scene& scene, const simulation::ListedEffect& effect)
        : renderer(scene, effect, RunContext()) {
      const double rate_hz = effect.timing.rate_hz;
      if (rate_hz > 0.0) interval_ns = std::llround(1e9 / rate_hz);
    }
    simulation::EffectImageRenderer renderer;
    std::int64_t interval_ns = 0;  ///< 0: with all images.
    std::int64_t due_ns = std::numeric_limits<std::int64_t>::min();
    std::optional<LiveSnapshot> shown;

    bool IsDue(std::int64_t time_ns) const { return time_ns + kRoundingNs >= due_ns; }
    /// A late image does not delay the next ones: they stay on the grid of the first.
    void SetNext(std::int64_t time_ns) {
      if (interval_ns == 0) return;
      if (due_ns == std::numeric_limits<std::int64_t>::min()) due_ns = time_ns;
      due_ns += ((time_ns + kRoundingNs - due_ns) / interval_ns + 1) * interval_ns;
    }
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
  std::optional<double> gain_db;  ///< The last requested value.
  std::optional<double> depth_mm;
  std::optional<simulation::ProbeImageRenderer> images;
  std::deque<OfEffect> effects;
};

ImageMaker::ImageMaker(const simulation::Scene& scene)
    : renderers_(std::make_unique<Renderers>(scene)), stage_times_(scene.plan) {
  for (const auto& effect : renderers_->effects) {
    const simulation::ListedEffect& of = effect.renderer.effect();
    last_effects_.push_back({of.key, of.title, {}});
  }
}

ImageMaker::~ImageMaker() = default;

void ImageMaker::Forget() {
  shown_.reset();
  for (auto& effect : renderers_->effects) effect.shown.reset();
}

void ImageMaker::SetProbe(const LiveSnapshot& snapshot) {
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
    r.images.emplace(r.scene, r.probe.get());  // An unsupported setting has no effect.
  }
}

void ImageMaker::Finish(const LiveSnapshot& snapshot, std::int64_t time_ns, LiveImage& out) {
  if (!snapshot.frozen) time_ns_ = time_ns;
  out.snapshot = snapshot;
  out.number = ++number_;
  out.time_ns = time_ns_;
  out.probe = renderers_->probe;
  out.images = last_images_;
  out.effects = last_effects_;
}

void ImageMaker::Make(const LiveSnapshot& snapshot, LiveImage& out) {
  const simulation::Snapshot moment = snapshot.ForRenderer();
  if (!snapshot.frozen) {
    SetProbe(snapshot);
    std::optional<simulation::Snapshot> shown;
    if (shown_) shown = shown_->ForRenderer();
    renderers_->images->Render(moment, last_images_, &stage_times_, shown ? &*shown : nullptr);
    shown_ = snapshot;
    for (std::size_t n = 0; n < renderers_->effects.size(); ++n) {
      auto& effect = renderers_->effects[n];
      if (!effect.IsDue(moment.time_ns)) continue;
      shown.reset();
      if (effect.shown) shown = effect.shown->ForRenderer();
      effect.renderer.Render(moment, &last_images_, last_effects_[n].pixels, &stage_times_,
                             shown ? &*shown : nullptr);
      effect.shown = snapshot;
      effect.SetNext(moment.time_ns);
    }
  }
  Finish(snapshot, moment.time_ns, out);
}

namespace {

bool Fits(const image::GrayImage& image, const image::ImageGeometry& size) {
  return image.pixels.empty() || (image.width == size.width_px && image.height == size.height_px);
}

}  // namespace

bool ImageMaker::Take(const LiveSnapshot& snapshot, const MadeImages& made, LiveImage& out) {
  if (!snapshot.frozen) {
    SetProbe(snapshot);
    image::ImageGeometry size;  // Without a probe there are no such images.
    if (renderers_->probe) size = acoustics::ImageOf(*renderers_->probe);
    if (!Fits(made.images.b_mode, size) || !Fits(made.images.ct_slice, size)) return false;
    last_images_ = made.images;
    for (std::size_t n = 0; n < last_effects_.size() && n < made.effects.size(); ++n) {
      last_effects_[n].pixels = made.effects[n];
    }
    Forget();
  }
  Finish(snapshot, made.time_ns, out);
  return true;
}

}  // namespace acus::live
