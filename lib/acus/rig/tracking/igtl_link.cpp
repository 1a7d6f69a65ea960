#include "acus/rig/tracking/igtl_link.h"

#include <poll.h>

#include "acus/base/core/error.h"

namespace acus::tracking {

IgtlLink::IgtlLink(Descriptor socket)
    : socket_(std::move(socket)),
      peer_(PeerName(socket_)),
      reader_({.keep_images = true, .keep_tables = true, .check_crc = true}) {}

void IgtlLink::Fail(const std::string& why) {
  if (trouble_.empty()) trouble_ = why;
}

void IgtlLink::Queue(Bytes message) {
  queued_bytes_ += message.size();
  queue_.push_back(std::move(message));
}

bool IgtlLink::Exchange(int wait_ms, const WakeUp& wake) {
  if (!ok()) return false;
  const short out = queue_.empty() ? 0 : POLLOUT;
  pollfd waits[] = {{.fd = socket_.get(), .events = static_cast<short>(POLLIN | out), .revents = 0},
                    {.fd = wake.fd(), .events = POLLIN, .revents = 0}};
  poll(waits, 2, wait_ms);
  SendSome();
  if ((waits[0].revents & (POLLIN | POLLERR | POLLHUP)) != 0) ReceiveSome();
  return ok();
}

void IgtlLink::SendSome() {
  while (!queue_.empty()) {
    const Transfer transfer = Send(socket_, ByteView(queue_.front()).subspan(sent_bytes_));
    if (transfer.state == TransferState::kClosed) {
      Fail(Message(peer_, " closed the link"));
      return;
    }
    if (transfer.state == TransferState::kWouldBlock) return;
    sent_bytes_ += transfer.bytes;
    if (sent_bytes_ < queue_.front().size()) continue;
    queued_bytes_ -= queue_.front().size();
    queue_.pop_front();
    sent_bytes_ = 0;
  }
}

void IgtlLink::ReceiveSome() {
  const Transfer transfer = Receive(socket_, chunk_);
  if (transfer.state == TransferState::kClosed) {
    Fail(Message(peer_, " closed the link", transfer.error.empty() ? "" : ": ", transfer.error));
    return;
  }
  reader_.Append(ByteView(chunk_).first(transfer.bytes));
}

std::optional<IgtlMessage> IgtlLink::Next() {
  if (!ok()) return std::nullopt;
  auto message = reader_.Next();
  if (reader_.counts().bad_messages > 0 || reader_.counts().skipped_bytes > 0) {
    Fail(Message(peer_, " sent bytes that are no OpenIGTLink message"));
    return std::nullopt;
  }
  return message;
}

}  // namespace acus::tracking
