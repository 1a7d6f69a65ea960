#include "acus/run/live/image_server.h"

#include <poll.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/run/live/image_follower.h"
#include "acus/run/live/image_maker.h"

namespace acus::live {
namespace {

constexpr int kServerTurnMs = 50;
constexpr std::int64_t kRequestNs = 2'000'000'000;
constexpr std::size_t kMostQueuedImages = 64 * 1024 * 1024;

}  // namespace

std::pair<std::string, int> ListenAddress(const std::string& text) {
  const bool is_port = text.find_first_not_of("0123456789") == std::string::npos;
  return tracking::ParseAddress(is_port ? "localhost:" + text : text, kImagePort);
}

ImageServer::ImageServer(const simulation::Scene& scene, std::string digest,
                         ImageServerOptions options)
    : scene_(scene),
      digest_(std::move(digest)),
      options_(std::move(options)),
      listener_(tracking::ListenTcp(options_.host, options_.port)) {}

void ImageServer::Say(const std::string& line) const {
  if (options_.on_event) options_.on_event(line);
}

bool ImageServer::Continues() const {
  if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) return false;
  return options_.duration_s <= 0.0 ||
         1e-9 * static_cast<double>(MonotonicNs() - begin_ns_) < options_.duration_s;
}

void ImageServer::Run(const std::atomic<bool>* stop) {
  stop_ = stop;
  begin_ns_ = MonotonicNs();
  while (Continues()) {
    pollfd wait{.fd = listener_.get(), .events = POLLIN, .revents = 0};
    if (poll(&wait, 1, kServerTurnMs) <= 0) continue;
    tracking::Descriptor socket = tracking::AcceptTcp(listener_);
    if (!socket.valid()) continue;
    tracking::IgtlLink link(std::move(socket));
    if (Accepts(link)) Serve(link);
  }
}

void ImageServer::Refuse(tracking::IgtlLink& link, const std::string& why) {
  Say(Message(link.peer(), " is refused: ", why));
  link.Queue(tracking::PackStatus("Images", 0, false, why));
  const std::int64_t give_up_ns = MonotonicNs() + kRequestNs;
  while (link.queued_bytes() > 0 && MonotonicNs() < give_up_ns &&
         link.Exchange(kServerTurnMs, wake_)) {
    while (link.Next()) {
    }
  }
}

bool ImageServer::Accepts(tracking::IgtlLink& link) {
  const std::int64_t give_up_ns = MonotonicNs() + kRequestNs;
  while (Continues() && MonotonicNs() < give_up_ns && link.Exchange(kServerTurnMs, wake_)) {
    const auto message = link.Next();
    if (!message) continue;
    const auto digest = ReadRequest(message->header, message->body.content);
    if (!digest) {
      Refuse(link, "that is no request for images");
    } else if (*digest != digest_) {
      Refuse(link, "another patient, scenario or build; start both programs with the same of each");
    } else {
      link.Queue(tracking::PackStatus("Images", 0, true, "images follow"));
      return true;
    }
    return false;
  }
  return false;
}

/// Refuses further clients while a session runs.
void ImageServer::TellOthers() {
  tracking::Descriptor socket = tracking::AcceptTcp(listener_);
  if (!socket.valid()) return;
  const auto busy = tracking::PackStatus("Images", 0, false, "it makes images for another session");
  tracking::Send(socket, busy);  // Does not wait for a client that does not read.
}

void ImageServer::Serve(tracking::IgtlLink& link) {
  Say("Images for " + link.peer() + ".");
  ImageFollower follower(scene_, options_.has_needle, options_.has_probe,
                         options_.least_image_rate_hz);
  ImageMaker maker(scene_);
  MomentPacker packer(scene_);
  LiveImage image;
  std::int64_t steps = 0;
  std::int64_t newest_ns = INT64_MIN;
  while (Continues() && link.Exchange(kServerTurnMs, wake_)) {
    while (const auto message = link.Next()) {
      const auto inputs = message->header.type == "NDARRAY"
                              ? ReadSteps(message->body.content, steps, newest_ns)
                              : std::nullopt;
      if (!inputs) {
        Refuse(link, "that are no steps of a session");
        return;
      }
      for (const StepInput& input : *inputs) follower.Step(input);
      steps += static_cast<std::int64_t>(inputs->size());
      newest_ns = inputs->back().time_ns;
    }
    TellOthers();
    // If images cannot keep up, only the newest one is rendered.
    if (link.queued_bytes() > 0) {
      if (link.queued_bytes() > kMostQueuedImages) link.Fail(link.peer() + " takes no images");
      continue;
    }
    if (const LiveSnapshot* moment = follower.TakeMoment()) {
      maker.Make(*moment, image);
      for (tracking::Bytes& message : packer.Pack(image)) link.Queue(std::move(message));
    }
  }
  Say(Message("Ended: ", steps, " steps, ", image.number, " images, ", follower.passed_over(),
              " passed over", link.ok() ? "" : "; ", link.trouble(), "."));
}

}  // namespace acus::live
