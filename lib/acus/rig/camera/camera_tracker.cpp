#include "acus/rig/camera/camera_tracker.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::camera {
namespace {

constexpr int kWaitMs = 50;  ///< For an image; bounds how long Stop() takes.

std::vector<std::string> ToolNames(const std::vector<CameraTool>& tools) {
  std::vector<std::string> names;
  for (const CameraTool& tool : tools) names.push_back(tool.tool);
  return names;
}

/// Beside a second camera its images are read as they come, so that their times can be compared.
std::unique_ptr<FrameSource> OpenFirst(const CameraTrackerOptions& options) {
  auto source = OpenFrameSource(options.place, options.source);
  if (!options.second || IsRecorded(options.place)) return source;
  return std::make_unique<NewestFrames>(std::move(source));
}

}  // namespace

class CameraTracker::Worker {
 public:
  Worker(CameraModel camera, FacetSet facets, CameraTrackerOptions options)
      : camera_(std::move(camera)),
        facets_(std::move(facets)),
        options_(std::move(options)),
        source_(OpenFirst(options_)),
        detector_(facets_.dictionary, options_.detector),
        board_(ToolNames(options_.tools), options_.journal_capacity) {
    std::vector<std::string> wanted;
    if (!options_.reference.empty()) wanted.push_back(options_.reference);
    for (const CameraTool& tool : options_.tools) wanted.push_back(tool.object);
    for (const std::string& object : wanted) {
      ACUS_REQUIRE(facets_.Find(object) != nullptr, "camera '", options_.name, "': object '",
                   object, "' is not in the facet set '", facets_.name, "'");
    }
    if (!options_.second) return;
    RequireSameCamera(options_.second->pair.left, camera_, "left");
    second_ = std::make_unique<SecondCamera>(*options_.second, options_.source);
  }
  ~Worker() { Stop(); }

  void Start() {
    if (thread_.joinable()) return;
    stop_ = false;
    thread_ = std::thread([this] { Run(); });
  }
  void Stop() noexcept {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    const std::lock_guard lock(mutex_);
    status_.state = tracking::SourceState::kStopped;
  }

  tracking::SourceStatus status() const {
    const std::lock_guard lock(mutex_);
    tracking::SourceStatus status = status_;
    status.counts.lost_from_journal = board_.lost_from_journal();
    return status;
  }
  std::shared_ptr<const CameraView> latest() const {
    const std::lock_guard lock(mutex_);
    return latest_;
  }
  const CameraModel& camera() const { return camera_; }
  const CameraTrackerOptions& options() const { return options_; }
  tracking::PoseBoard& board() { return board_; }

 private:
  void Run() {
    std::int64_t last_image_ns = MonotonicNs();
    bool is_lost = false;
    while (!stop_) {
      auto view = std::make_shared<CameraView>();
      bool got = false;
      try {
        got = source_->Next(view->image, kWaitMs) && Fits(view->image);
        if (got) Locate(*view);
      } catch (const std::exception& error) {  // An image must not end the session.
        got = false;
        const std::lock_guard lock(mutex_);
        status_.last_error = error.what();
        ++status_.counts.bad_messages;
      }
      const std::int64_t now = MonotonicNs();
      if (got) {
        last_image_ns = now;
        is_lost = false;
        Publish(std::move(view));
      } else if (!is_lost &&
                 now - last_image_ns > std::int64_t{options_.lost_after_ms} * 1'000'000) {
        is_lost = true;
        PublishLost(now);
      }
      TakeStatus();
      // A video that is over must not keep a processor busy.
      if (!got && source_->finished()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(kWaitMs));
      }
    }
  }

  bool Fits(const Image& image) {
    const CameraParameters& p = camera_.parameters();
    if (image.width_px == p.width_px && image.height_px == p.height_px) return true;
    const std::lock_guard lock(mutex_);
    ++status_.counts.bad_messages;
    status_.last_error = Message("the image has ", image.width_px, " x ", image.height_px,
                                 " pixels, the camera's file says ", p.width_px, " x ", p.height_px,
                                 ": set the camera to that size, or calibrate at this one");
    return false;
  }

  void Locate(CameraView& view) {
    const auto seen = detector_.Detect(view.image, &camera_);
    const auto seen_by_second = SeenBySecond(view.image.time_ns);
    for (const FacetObject& object : facets_.objects) {
      const auto before = previous_.find(object.name);
      auto found = Find(object, seen, seen_by_second,
                        before == previous_.end() ? std::nullopt : std::optional(before->second));
      if (!found) {
        previous_.erase(object.name);
        continue;
      }
      agreement_.Count(found->use);
      view.by_pair += found->use == PairUse::kBoth ? 1 : 0;
      if (!found->pose.ambiguous) previous_[object.name] = found->pose.camera_from_object;
      view.objects.push_back(std::move(found->pose));
    }
    if (agreement_.refused()) view.objects.clear();
    const std::int64_t now = view.image.time_ns;
    if (const ObjectPose* reference = Usable(view, options_.reference)) {
      reference_ = reference->camera_from_object;
      reference_ns_ = now;
    } else if (now - reference_ns_ > std::int64_t{options_.hold_reference_ms} * 1'000'000) {
      reference_.reset();
    }
    if (options_.reference.empty()) reference_ = Eigen::Isometry3d::Identity();
    view.camera_from_reference = reference_;
  }

  std::vector<DetectedMarker> SeenBySecond(std::int64_t time_ns) {
    if (second_ == nullptr) return {};
    const auto image = second_->At(time_ns);
    if (!image) return {};
    return detector_.Detect(*image, &options_.second->pair.right);
  }

  std::optional<PairPose> Find(const FacetObject& object, std::span<const DetectedMarker> seen,
                               std::span<const DetectedMarker> seen_by_second,
                               const std::optional<Eigen::Isometry3d>& before) const {
    if (second_ != nullptr) {
      return LocateObjectInPair(object, seen, seen_by_second, options_.second->pair, options_.pose,
                                before);
    }
    auto pose = LocateObject(object, seen, camera_, options_.pose, before);
    if (!pose) return std::nullopt;
    return PairPose{.pose = std::move(*pose)};
  }

  /// What is the matter with the pair; empty if nothing, or if there is none.
  std::string ProblemOfPair() const {
    if (agreement_.refused()) return agreement_.Problem();
    return second_ == nullptr ? "" : second_->Problem();
  }

  static const ObjectPose* Usable(const CameraView& view, const std::string& object) {
    for (const ObjectPose& pose : view.objects) {
      if (pose.name == object && !pose.ambiguous) return &pose;
    }
    return nullptr;
  }

  void Publish(std::shared_ptr<CameraView> view) {
    std::uint64_t not_seen = 0;
    for (std::size_t i = 0; i < options_.tools.size(); ++i) {
      const ObjectPose* pose = Usable(*view, options_.tools[i].object);
      tracking::TrackedPose reading;
      reading.time_ns = MonotonicNs();
      reading.measured_ns = view->image.time_ns;
      reading.valid = pose != nullptr && reference_.has_value();
      if (reading.valid) {
        reading.reference_from_tool = transforms::Pose(
            reference_->inverse() * pose->camera_from_object * options_.tools[i].object_from_tool);
      }
      not_seen += reading.valid ? 0 : 1;
      board_.Publish(i, reading);
    }
    const std::lock_guard lock(mutex_);
    ++status_.counts.messages;
    status_.counts.readings += options_.tools.size();
    status_.counts.not_seen += not_seen;
    status_.last_news_ns = view->image.time_ns;
    view->number = status_.counts.messages;
    latest_ = std::move(view);
  }

  void PublishLost(std::int64_t now) {
    previous_.clear();
    reference_.reset();
    for (std::size_t i = 0; i < options_.tools.size(); ++i) {
      tracking::TrackedPose reading;
      reading.time_ns = reading.measured_ns = now;
      board_.Publish(i, reading);
    }
    const std::lock_guard lock(mutex_);
    status_.counts.readings += options_.tools.size();
    status_.counts.fell_silent += options_.tools.size();
  }

  void TakeStatus() {
    const FrameSourceStatus source = source_->status();
    const std::lock_guard lock(mutex_);
    const bool connected = source.connected;
    if (connected && status_.state != tracking::SourceState::kConnected) ++status_.counts.connects;
    if (!connected) status_.last_error = source.text;
    status_.peer_status = source.text;
    const std::string problem = ProblemOfPair();
    if (!problem.empty() && (connected || agreement_.refused())) {
      status_.last_error = status_.peer_status = problem;
    }
    status_.state =
        connected ? tracking::SourceState::kConnected : tracking::SourceState::kConnecting;
  }

  CameraModel camera_;
  FacetSet facets_;
  CameraTrackerOptions options_;
  std::unique_ptr<FrameSource> source_;
  std::unique_ptr<SecondCamera> second_;
  MarkerDetector detector_;
  tracking::PoseBoard board_;
  // State of the thread.
  std::map<std::string, Eigen::Isometry3d> previous_;
  std::optional<Eigen::Isometry3d> reference_;
  std::int64_t reference_ns_ = 0;
  PairAgreement agreement_;

  std::thread thread_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  tracking::SourceStatus status_;             // By the mutex,
  std::shared_ptr<const CameraView> latest_;  // as is this.
};

CameraTracker::CameraTracker(CameraModel camera, FacetSet facets, CameraTrackerOptions options)
    : worker_(std::make_unique<Worker>(std::move(camera), std::move(facets), std::move(options))) {}
CameraTracker::~CameraTracker() = default;

std::string CameraTracker::name() const {
  return worker_->options().name;
}
void CameraTracker::Start() {
  worker_->Start();
}
void CameraTracker::Stop() noexcept {
  worker_->Stop();
}
tracking::PoseBoard& CameraTracker::board() noexcept {
  return worker_->board();
}
tracking::SourceStatus CameraTracker::status() const {
  return worker_->status();
}
const CameraModel& CameraTracker::camera() const {
  return worker_->camera();
}
std::shared_ptr<const CameraView> CameraTracker::Latest() const {
  return worker_->latest();
}

}  // namespace acus::camera
