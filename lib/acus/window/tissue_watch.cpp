#include "acus/window/tissue_watch.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "acus/scene/effects/view_3d/tissue_under_tools.h"
#include "acus/scene/simulation/image_sleep.h"
#include "acus/scene/simulation/moment_rest.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::window {
namespace {

using volume_rendering::PressedTissue;

constexpr int kWatchNice = 5;
/// Coarser than in replays: the views are rendered all the time.
constexpr int kMostKnots = 8000;

}  // namespace

struct TissueWatch::Content {
  explicit Content(const simulation::Scene& of_scene)
      : scene(of_scene), rest(of_scene, /*beyond_skin=*/true), thread([this] { Work(); }) {}

  const simulation::Scene& scene;
  simulation::MomentRest rest;  ///< Used by the thread only.

  std::mutex mutex;
  std::condition_variable changed;
  std::unique_ptr<live::LiveSnapshot> asked;    ///< The last requested one.
  std::unique_ptr<live::LiveSnapshot> waiting;  ///< Not begun yet.
  bool busy = false;
  std::shared_ptr<const PressedTissue> newest;
  bool stop = false;
  std::thread thread;

  bool HasStayed(const live::LiveSnapshot& now) const {
    if (!asked) return false;
    const simulation::Snapshot before_moment = asked->ForRenderer();
    const simulation::Snapshot now_moment = now.ForRenderer();
    return simulation::TissueHasStayed(scene, before_moment, now_moment) &&
           simulation::ProbeHasStayed(before_moment, now_moment);
  }

  std::shared_ptr<const PressedTissue> Pressed(const live::LiveSnapshot& snapshot) {
    const simulation::Snapshot moment = snapshot.ForRenderer();
    const slicing::RestMap* map = rest.At(moment);
    if (map == nullptr) return nullptr;
    effects::ToolsOnTissue tools;
    tools.needle = simulation::ImagedNeedle(scene, moment);
    if (moment.probe_valid) tools.ct_from_probe = moment.ct_from_probe;
    if (scene.probe) tools.probe = &*scene.probe;
    std::optional<breathing::MotionMap> breath;
    int iterations = 1;
    if (scene.breathing && scene.breathing->image) {
      breath.emplace(scene.breathing->At(moment.session_s, moment.breath));
      iterations = scene.breathing->inverse_iterations;
    }
    auto pressed = std::make_shared<const PressedTissue>(
        effects::PressedIn(*map, breath ? &*breath : nullptr, effects::ReachOf(tools),
                           {.most_knots = kMostKnots}, iterations));
    return pressed->empty() ? nullptr : pressed;
  }

  void Work() {
    const auto thread_id = static_cast<id_t>(gettid());
    setpriority(PRIO_PROCESS, thread_id, getpriority(PRIO_PROCESS, thread_id) + kWatchNice);
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stop || waiting; });
      if (stop) return;
      const auto snapshot = std::exchange(waiting, nullptr);
      busy = true;
      lock.unlock();
      auto pressed = Pressed(*snapshot);
      lock.lock();
      newest = std::move(pressed);
      busy = false;
      changed.notify_all();
    }
  }
};

TissueWatch::TissueWatch(const simulation::Scene& scene) {
  if (scene.tools_deform_images || scene.pressed_by_proxies)
    content_ = std::make_unique<Content>(scene);
}

TissueWatch::~TissueWatch() {
  if (!content_) return;
  {
    const std::lock_guard lock(content_->mutex);
    content_->stop = true;
  }
  content_->changed.notify_all();
  content_->thread.join();
}

void TissueWatch::Ask(const live::LiveSnapshot& snapshot) {
  if (!content_) return;
  {
    const std::lock_guard lock(content_->mutex);
    if (content_->HasStayed(snapshot)) return;
    content_->asked = std::make_unique<live::LiveSnapshot>(snapshot);
    content_->waiting = std::make_unique<live::LiveSnapshot>(snapshot);
  }
  content_->changed.notify_all();
}

std::shared_ptr<const PressedTissue> TissueWatch::Newest() const {
  if (!content_) return nullptr;
  const std::lock_guard lock(content_->mutex);
  return content_->newest;
}

void TissueWatch::Wait() {
  if (!content_) return;
  std::unique_lock lock(content_->mutex);
  content_->changed.wait(lock, [&] { return !content_->waiting && !content_->busy; });
}

}  // namespace acus::window
