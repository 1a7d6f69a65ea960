// One client of the pose server: what waits for it, and what it requested.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "acus/rig/tracking/igtl_reader.h"
#include "acus/rig/tracking/socket.h"

namespace acus::tracking {

using SharedBytes = std::shared_ptr<const Bytes>;

/// Used by the server's thread only.
class ServerClient {
 public:
  ServerClient(Descriptor socket, std::size_t max_backlog_bytes);

  const Descriptor& socket() const { return socket_; }
  const std::string& peer() const { return peer_; }

  /// Queues poses, or whatever must not be omitted.
  void Add(const SharedBytes& bytes);
  /// Queues an image; the one of the stream that still waits is replaced. @returns whether it was.
  bool AddImage(const std::string& stream, const SharedBytes& bytes);
  /// Queues TDATA if the client's interval has passed.
  void AddTrackingData(const SharedBytes& bytes, std::int64_t time_ns);

  /// Sends as much as goes, of a large message a piece. False: the link is lost.
  bool SendWaiting();
  bool has_waiting() const { return current_ != nullptr || !poses_.empty() || !images_.empty(); }
  bool is_too_slow() const { return backlog_bytes_ > max_backlog_bytes_; }

  bool wants_tracking_data() const { return interval_ms_ >= 0; }
  void StartTrackingData(int interval_ms);
  void StopTrackingData() { interval_ms_ = -1; }

  IgtlReader& reader() { return reader_; }

 private:
  Descriptor socket_;
  std::string peer_;
  std::size_t max_backlog_bytes_;
  IgtlReader reader_{IgtlReader::Options{}};
  std::deque<SharedBytes> poses_;
  std::map<std::string, SharedBytes> images_;
  std::size_t backlog_bytes_ = 0;
  SharedBytes current_;  ///< Being sent, and how much of it is.
  std::size_t sent_bytes_ = 0;
  int interval_ms_ = -1;
  std::int64_t due_ns_ = 0;
};

}  // namespace acus::tracking
