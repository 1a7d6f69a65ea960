#include "acus/run/live/remote_images.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::live {
namespace {

constexpr int kConnectMs = 2000;
constexpr int kAnswerMs = 2000;
constexpr int kTurnMs = 3;  // Longest delay of a step to send several together.
constexpr std::int64_t kMostBehindNs = 2'000'000'000;
constexpr std::size_t kMostQueuedBytes = 4 * 1024 * 1024;

}  // namespace

RemoteImages::RemoteImages(const ImagesFrom& where, const simulation::Scene& scene,
                           std::string digest)
    : where_(where),
      place_(Message(where.host, ":", where.port)),
      digest_(std::move(digest)),
      reader_(scene) {}

RemoteImages::~RemoteImages() {
  Stop();
}

bool RemoteImages::Connect() {
  tracking::Connection connection =
      tracking::ConnectTcp(where_.host, where_.port, kConnectMs, wake_);
  if (!connection.socket.valid()) {
    Lose(connection.error);
    return false;
  }
  link_ = std::make_unique<tracking::IgtlLink>(std::move(connection.socket));
  link_->Queue(PackRequest(digest_));
  const std::int64_t give_up_ns = MonotonicNs() + std::int64_t{kAnswerMs} * 1'000'000;
  while (link_->Exchange(kTurnMs, wake_) && MonotonicNs() < give_up_ns) {
    const auto message = link_->Next();
    if (!message) continue;
    const auto answer = message->header.type == "STATUS"
                            ? tracking::ReadStatus(message->body.content)
                            : std::optional<std::string>("it answers with something else");
    if (answer && answer->starts_with("OK")) return true;
    Lose(Message(place_, ": ", answer.value_or("its answer is not readable")));
    return false;
  }
  Lose(link_->ok() ? Message(place_, " does not answer; it runs acus-live --make-images?")
                   : link_->trouble());
  return false;
}

void RemoteImages::Start(std::int64_t origin_ns) {
  origin_ns_ = origin_ns;
  progress_ns_ = MonotonicNs();
  if (link_ == nullptr || !trouble().empty()) return;
  thread_ = std::thread([this] { Run(); });
}

void RemoteImages::Stop() noexcept {
  stopping_ = true;
  wake_.Ring();
  if (thread_.joinable()) thread_.join();
  works_ = false;
  feed_.Close();
  link_.reset();
}

void RemoteImages::Run() noexcept {
  try {
    while (!stopping_ && link_->Exchange(kTurnMs, wake_)) {
      SendSteps();
      TakeMessages();
      CheckProgress();
    }
    if (!link_->ok()) Lose(link_->trouble());
  } catch (const std::exception& error) {
    Lose(error.what());
  }
}

void RemoteImages::SendSteps() {
  if (feed_.lost()) link_->Fail(place_ + ": steps for it were lost");
  if (link_->queued_bytes() > kMostQueuedBytes) link_->Fail(place_ + " takes no steps");
  while (const StepInput* step = feed_.Front()) {
    steps_.push_back(*step);
    feed_.Pop();
    if (steps_.size() == kMostStepsInMessage) break;  // The rest in the next turn.
  }
  if (steps_.empty() || !link_->ok()) return;
  link_->Queue(PackSteps(steps_, sent_steps_));
  sent_steps_ += static_cast<std::int64_t>(steps_.size());
  steps_sent_ = sent_steps_;
  sent_ns_ = steps_.back().time_ns;
  steps_.clear();
}

void RemoteImages::TakeMessages() {
  while (const auto message = link_->Next()) {
    if (message->header.type == "STATUS") {
      const auto text = tracking::ReadStatus(message->body.content);
      link_->Fail(Message(place_, ": ", text.value_or("its status is not readable")));
      return;
    }
    if (!reader_.Take(message->header, message->body.content)) {
      link_->Fail(Message(place_, " sent ", message->header.type, " ", message->header.device,
                          ", which is no image of this session"));
      return;
    }
    if (!reader_.TakeWhole()) continue;
    const std::int64_t now_ns = MonotonicNs();
    age_.Add(now_ns - origin_ns_ - reader_.images().time_ns);
    newest_ns_ = reader_.images().time_ns;
    progress_ns_ = now_ns;
    ++images_;
    auto images = std::make_shared<const MadeImages>(reader_.images());
    {
      const std::lock_guard lock(mutex_);
      newest_ = std::move(images);
    }
    works_ = true;
  }
}

/// Detects a remote that receives steps and returns no images: it is too slow, or has stopped.
void RemoteImages::CheckProgress() {
  if (sent_steps_ == 0) progress_ns_ = MonotonicNs();
  const bool is_behind = sent_ns_ - newest_ns_ > kMostBehindNs;
  if (is_behind && MonotonicNs() - progress_ns_ > kMostBehindNs) {
    link_->Fail(place_ + " has sent no image for 2 s");
  }
}

void RemoteImages::Lose(const std::string& why) noexcept {
  feed_.Close();
  works_ = false;
  const std::lock_guard lock(mutex_);
  if (trouble_.empty()) trouble_ = why;
}

std::shared_ptr<const MadeImages> RemoteImages::Newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

double RemoteImages::age_ms() const {
  return 1e-6 * static_cast<double>(MonotonicNs() - origin_ns_ - newest_ns_);
}

std::string RemoteImages::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

nlohmann::json RemoteImages::ToJson() const {
  return {{"place", place_},
          {"images", images_.load()},
          {"steps_sent", steps_sent_.load()},
          {"age", age_.ToJson()},
          {"trouble", trouble()}};
}

}  // namespace acus::live
