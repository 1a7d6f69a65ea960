#include "acus/rig/tracking/server_client.h"

#include <algorithm>

namespace acus::tracking {
namespace {

constexpr std::size_t kMostBytesAtOnce = 4 * 1024 * 1024;

}  // namespace

ServerClient::ServerClient(Descriptor socket, std::size_t max_backlog_bytes)
    : socket_(std::move(socket)), peer_(PeerName(socket_)), max_backlog_bytes_(max_backlog_bytes) {}

void ServerClient::Add(const SharedBytes& bytes) {
  poses_.push_back(bytes);
  backlog_bytes_ += bytes->size();
}

bool ServerClient::AddImage(const std::string& stream, const SharedBytes& bytes) {
  SharedBytes& waiting = images_[stream];
  const bool replaced = waiting != nullptr;
  waiting = bytes;
  return replaced;
}

void ServerClient::StartTrackingData(int interval_ms) {
  interval_ms_ = interval_ms;
  due_ns_ = INT64_MIN / 2;  // At once; sums with it do not overflow.
}

void ServerClient::AddTrackingData(const SharedBytes& bytes, std::int64_t time_ns) {
  const std::int64_t interval_ns = std::int64_t{interval_ms_} * 1'000'000;
  // A tenth of grace: poses at just the asked rate, a little early, would else be every other one.
  if (time_ns < due_ns_ - interval_ns / 10) return;
  due_ns_ = std::max(due_ns_, time_ns - interval_ns / 2) + interval_ns;
  Add(bytes);
}

bool ServerClient::SendWaiting() {
  // A volume is sent in pieces, so that others do not wait for it.
  for (std::size_t sent = 0; sent < kMostBytesAtOnce;) {
    if (current_ == nullptr) {
      sent_bytes_ = 0;
      if (!poses_.empty()) {
        current_ = std::move(poses_.front());
        poses_.pop_front();
        backlog_bytes_ -= current_->size();
      } else if (!images_.empty()) {
        current_ = std::move(images_.begin()->second);
        images_.erase(images_.begin());
      } else {
        return true;
      }
    }
    const Transfer transfer = Send(socket_, ByteView(*current_).subspan(sent_bytes_));
    if (transfer.state == TransferState::kClosed) return false;
    if (transfer.state == TransferState::kWouldBlock) return true;
    sent += transfer.bytes;
    sent_bytes_ += transfer.bytes;
    if (sent_bytes_ == current_->size()) current_.reset();
  }
  return true;
}

}  // namespace acus::tracking
