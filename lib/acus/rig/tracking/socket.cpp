#include "acus/rig/tracking/socket.h"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"

namespace acus::tracking {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses LookUp(const std::string& host, int port, bool to_listen, std::string& error) {
  addrinfo hints{};
  // Programs of others look for "localhost" at 127.0.0.1 only.
  const bool is_plain = to_listen && (host.empty() || host == "localhost");
  hints.ai_family = is_plain ? AF_INET : AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (to_listen ? AI_PASSIVE : 0);
  addrinfo* found = nullptr;
  const int failed = getaddrinfo(host.empty() ? nullptr : host.c_str(),
                                 std::to_string(port).c_str(), &hints, &found);
  if (failed != 0) error = gai_strerror(failed);
  return {failed == 0 ? found : nullptr, &freeaddrinfo};
}

void SetOption(int fd, int level, int option, int value) {
  setsockopt(fd, level, option, &value, sizeof(value));
}

/// Poses are small and urgent; a peer that is gone is noticed within about 4 s; the kernel holds at
/// most a few images, so that what waits can still be replaced by news.
void Tune(int fd) {
  SetOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  SetOption(fd, IPPROTO_TCP, TCP_KEEPIDLE, 1);
  SetOption(fd, IPPROTO_TCP, TCP_KEEPINTVL, 1);
  SetOption(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
  SetOption(fd, SOL_SOCKET, SO_SNDBUF, 512 * 1024);
}

/// Waits until the connection stands or failed. Empty if it stands.
std::string WaitForConnection(int fd, std::int64_t deadline_ns, const WakeUp& stop) {
  const auto left_ms = static_cast<int>((deadline_ns - MonotonicNs()) / 1'000'000);
  pollfd waits[] = {{.fd = fd, .events = POLLOUT, .revents = 0},
                    {.fd = stop.fd(), .events = POLLIN, .revents = 0}};
  const int ready = poll(waits, 2, std::max(left_ms, 0));
  if (ready > 0 && (waits[1].revents & POLLIN) != 0) return "stopped";
  if (ready <= 0) return "it took too long";
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  return error == 0 ? "" : std::strerror(error);
}

std::string NameOf(const sockaddr_storage& address, socklen_t size) {
  char host[NI_MAXHOST] = {}, port[NI_MAXSERV] = {};
  if (getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host, sizeof(host), port,
                  sizeof(port), NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "?";
  }
  return std::string(host) + ":" + port;
}

}  // namespace

void Descriptor::Close() noexcept {
  if (fd_ >= 0) close(fd_);
  fd_ = -1;
}

WakeUp::WakeUp() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  ACUS_REQUIRE(event_.valid(), "no more files can be opened: ", std::strerror(errno));
}

void WakeUp::Ring() const noexcept {
  const std::uint64_t one = 1;
  // Fails only if it rings already.
  [[maybe_unused]] const auto written = write(event_.get(), &one, sizeof(one));
}

void WakeUp::Clear() const noexcept {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto taken = read(event_.get(), &count, sizeof(count));
}

Connection ConnectTcp(const std::string& host, int port, int timeout_ms, const WakeUp& stop) {
  const std::string place = Message(host, ":", port);
  const std::int64_t deadline_ns = MonotonicNs() + std::int64_t{timeout_ms} * 1'000'000;
  std::string error;
  const Addresses addresses = LookUp(host, port, false, error);
  for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
    Descriptor socket(::socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket.valid()) {
      error = std::strerror(errno);
      continue;
    }
    if (connect(socket.get(), at->ai_addr, at->ai_addrlen) != 0 && errno != EINPROGRESS) {
      error = std::strerror(errno);
      continue;
    }
    error = WaitForConnection(socket.get(), deadline_ns, stop);
    if (!error.empty()) continue;
    Tune(socket.get());
    return {.socket = std::move(socket), .error = ""};
  }
  return {.socket = {}, .error = Message("no answer from ", place, " (", error, ")")};
}

Descriptor ListenTcp(const std::string& host, int port) {
  std::string error;
  const Addresses addresses = LookUp(host, port, true, error);
  for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
    Descriptor socket(::socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket.valid()) continue;
    SetOption(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1);
    if (bind(socket.get(), at->ai_addr, at->ai_addrlen) == 0 && listen(socket.get(), 16) == 0) {
      return socket;
    }
    error = std::strerror(errno);
  }
  throw InputError(Message("cannot listen on ", host.empty() ? "*" : host, ":", port, ": ", error,
                           ". Is another program using the port? Port 0 chooses a free one."));
}

int PortOf(const Descriptor& listener) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size);
  if (address.ss_family == AF_INET6) {
    return ntohs(reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
  }
  return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

Descriptor AcceptTcp(const Descriptor& listener) {
  Descriptor socket(accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (socket.valid()) Tune(socket.get());
  return socket;
}

std::string PeerName(const Descriptor& socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getpeername(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return "?";
  return NameOf(address, size);
}

Transfer Receive(const Descriptor& socket, std::span<std::uint8_t> into) {
  const auto count = recv(socket.get(), into.data(), into.size(), 0);
  if (count > 0) return {.state = TransferState::kOk, .bytes = std::size_t(count), .error = ""};
  if (count == 0) return {.state = TransferState::kClosed, .bytes = 0, .error = ""};
  if (errno == EAGAIN || errno == EINTR) {
    return {.state = TransferState::kWouldBlock, .bytes = 0, .error = ""};
  }
  return {.state = TransferState::kClosed, .bytes = 0, .error = std::strerror(errno)};
}

Transfer Send(const Descriptor& socket, std::span<const std::uint8_t> bytes) {
  const auto count = send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (count >= 0) return {.state = TransferState::kOk, .bytes = std::size_t(count), .error = ""};
  if (errno == EAGAIN || errno == EINTR) {
    return {.state = TransferState::kWouldBlock, .bytes = 0, .error = ""};
  }
  return {.state = TransferState::kClosed, .bytes = 0, .error = std::strerror(errno)};
}

std::pair<std::string, int> ParseAddress(const std::string& text, int default_port) {
  // "[::1]:18944" as well: the colons of the host stand in brackets.
  const auto bracket = text.rfind(']');
  const auto colon = text.rfind(':');
  const bool has_port =
      colon != std::string::npos && (bracket == std::string::npos || colon > bracket);
  std::string host = has_port ? text.substr(0, colon) : text;
  if (host.size() > 1 && host.front() == '[') host = host.substr(1, host.size() - 2);
  if (!has_port) return {host, default_port};
  const std::string digits = text.substr(colon + 1);
  const bool is_number = !digits.empty() && digits.size() <= 5 &&
                         digits.find_first_not_of("0123456789") == std::string::npos;
  ACUS_REQUIRE(is_number && std::stoi(digits) <= 65535, "address '", text,
               "': the port must be a number from 0 to 65535, as in localhost:18944");
  return {host, std::stoi(digits)};
}

}  // namespace acus::tracking
