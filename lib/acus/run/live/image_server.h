// The second computer: renders the images of live sessions that run elsewhere.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <utility>

#include "acus/base/core/run_context.h"
#include "acus/rig/tracking/igtl_link.h"
#include "acus/run/live/image_protocol.h"

namespace acus::live {

struct ImageServerOptions {
  std::string host = "localhost";  ///< Address of this computer to listen on; empty: all.
  int port = kImagePort;           ///< 0: any that is free.
  bool has_needle = true;          ///< Tools of the sessions.
  bool has_probe = true;
  double least_image_rate_hz = 30.0;
  double duration_s = 0.0;  ///< 0: until it is stopped.
  std::function<void(const std::string& line)> on_event =
      {};  ///< A session began, or ended; or empty.
};

/// "[HOST:]PORT" in its parts. Without a host it is "localhost", for clients on this computer;
/// ":18946" listens on the whole network. @throws InputError if the port is no number.
std::pair<std::string, int> ListenAddress(const std::string& text);

/// One session at a time, each from its first step on. One thread.
class ImageServer {
 public:
  /// Listens at once. @param scene  Must outlive this. @param digest  DigestOf() it.
  /// @throws InputError if the port is taken.
  ImageServer(const simulation::Scene& scene, std::string digest, ImageServerOptions options);

  int port() const { return tracking::PortOf(listener_); }
  /// Runs until the time is up, or `stop` (may be null) is true.
  void Run(const std::atomic<bool>* stop);

 private:
  bool Continues() const;
  void TellOthers();
  void Refuse(tracking::IgtlLink& link, const std::string& why);
  bool Accepts(tracking::IgtlLink& link);
  void Serve(tracking::IgtlLink& link);
  void Say(const std::string& line) const;

  const simulation::Scene& scene_;
  std::string digest_;
  ImageServerOptions options_;
  tracking::Descriptor listener_;
  tracking::WakeUp wake_;
  const std::atomic<bool>* stop_ = nullptr;
  std::int64_t begin_ns_ = 0;
};

}  // namespace acus::live
