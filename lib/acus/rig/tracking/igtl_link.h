// One link of OpenIGTLink between two programs that must agree on every byte.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "acus/rig/tracking/igtl_reader.h"
#include "acus/rig/tracking/socket.h"

namespace acus::tracking {

/// Messages in both directions over a connected socket. For one thread. A byte that belongs to no
/// whole and right message ends the link: unlike poses, what is sent here has to be complete.
class IgtlLink {
 public:
  explicit IgtlLink(Descriptor socket);

  const std::string& peer() const { return peer_; }
  /// Why the link is over; empty as long as it is not.
  const std::string& trouble() const { return trouble_; }
  bool ok() const { return trouble_.empty(); }

  /// A whole message, sent by Exchange().
  void Queue(Bytes message);
  std::size_t queued_bytes() const { return queued_bytes_; }

  /// Waits at most `wait_ms` for something to receive, or to be sent, or for `wake`; then sends and
  /// receives what can be without waiting. @returns ok(). @pre Next() has given nothing.
  bool Exchange(int wait_ms, const WakeUp& wake);
  /// The next message; holds until the next call. Nothing: there is none yet, or the link is over.
  std::optional<IgtlMessage> Next();
  /// Ends the link. Of several reasons the first counts.
  void Fail(const std::string& why);

 private:
  void SendSome();
  void ReceiveSome();

  Descriptor socket_;
  std::string peer_;
  std::string trouble_;
  IgtlReader reader_;
  std::deque<Bytes> queue_;
  std::size_t queued_bytes_ = 0;
  std::size_t sent_bytes_ = 0;  ///< Of the first in the queue.
  Bytes chunk_ = Bytes(256 * 1024);
};

}  // namespace acus::tracking
