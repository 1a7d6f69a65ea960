// TCP without surprises: nothing blocks, nothing raises a signal, everything closes itself.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace acus::tracking {

/// A file descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      Close();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  ~Descriptor() { Close(); }

  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  void Close() noexcept;

 private:
  int fd_ = -1;
};

/// Wakes a thread that waits in poll().
class WakeUp {
 public:
  WakeUp();
  void Ring() const noexcept;
  void Clear() const noexcept;
  int fd() const { return event_.get(); }

 private:
  Descriptor event_;
};

/// A connection that was made, or why not.
struct Connection {
  Descriptor socket = {};
  std::string error = {};  ///< "no answer from 10.0.0.5:18944 (connection refused)".
};

/// Connects within the time, unless `stop` rings. Looking a name up may take longer than that;
/// numbers and "localhost" do not.
Connection ConnectTcp(const std::string& host, int port, int timeout_ms, const WakeUp& stop);

/// Listens. Port 0 chooses a free one. @param host  "" for all addresses of this machine.
/// @throws InputError if the address is not ours or the port is taken.
Descriptor ListenTcp(const std::string& host, int port);
/// The port that a listening socket has.
int PortOf(const Descriptor& listener);
/// Takes a waiting connection; an invalid descriptor if there is none.
Descriptor AcceptTcp(const Descriptor& listener);
/// "10.0.0.5:49152", of the other side.
std::string PeerName(const Descriptor& socket);

enum class TransferState { kOk, kWouldBlock, kClosed };
struct Transfer {
  TransferState state = TransferState::kOk;
  std::size_t bytes = 0;
  std::string error = {};  ///< For kClosed: why, if it was not the other side's wish.
};
/// As much as there is, up to the size of `into`.
Transfer Receive(const Descriptor& socket, std::span<std::uint8_t> into);
/// As much as the other side takes now.
Transfer Send(const Descriptor& socket, std::span<const std::uint8_t> bytes);

/// "host:port", "host", ":port" in its parts; port `default_port` if it is not said.
/// @throws InputError if the port is not a number from 0 to 65535.
std::pair<std::string, int> ParseAddress(const std::string& text, int default_port);

}  // namespace acus::tracking
