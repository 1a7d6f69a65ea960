#include "acus/rig/tracking/pose_server.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <list>
#include <map>
#include <mutex>
#include <poll.h>
#include <thread>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/tracking/server_client.h"

namespace acus::tracking {
namespace {

constexpr std::uint64_t kMaxUnreadBytes = 64 * 1024;
const std::vector<std::string> kCapabilities = {
    "TRANSFORM", "TDATA",  "STT_TDATA",  "STP_TDATA",   "IMAGE",
    "POINT",     "STATUS", "GET_STATUS", "GET_CAPABIL", "CAPABILITY"};

/// What is to be added to MonotonicNs() for UTC.
std::int64_t UtcOffsetNs() {
  timespec utc{};
  clock_gettime(CLOCK_REALTIME, &utc);
  return std::int64_t{utc.tv_sec} * 1'000'000'000 + utc.tv_nsec - MonotonicNs();
}

/// What producers hand to the network thread.
struct Parcel {
  enum Kind { kPoses, kImage, kKept, kForAll, kDisconnect } kind;
  SharedBytes bytes = nullptr;          ///< Poses: as TRANSFORM messages.
  SharedBytes tracking_data = nullptr;  ///< The same as TDATA.
  std::string stream = {};
  std::int64_t time_ns = 0;
};

SharedBytes Shared(Bytes bytes) {
  return std::make_shared<const Bytes>(std::move(bytes));
}

}  // namespace

class PoseServer::Network {
 public:
  explicit Network(PoseServerOptions options) : options_(std::move(options)) {
    ACUS_REQUIRE(options_.port >= 0 && options_.port <= 65535, "server '", options_.name,
                 "': port is ", options_.port, "; allowed are 0 to 65535");
    ACUS_REQUIRE(options_.max_clients >= 1, "server '", options_.name,
                 "': max_clients must be at least 1");
  }

  void Start();
  void Stop() noexcept;
  void Post(Parcel parcel);
  SharedBytes TransformsOf(std::span<const NamedPose> poses, std::int64_t time_ns) const;
  SharedBytes TrackingDataOf(std::span<const NamedPose> poses, std::int64_t time_ns) const;
  std::int64_t UtcNs(std::int64_t time_ns) const { return time_ns + utc_offset_ns_; }

  const PoseServerOptions& options() const { return options_; }
  bool has_clients() const { return num_clients_.load(std::memory_order_relaxed) > 0; }
  bool wants_tracking_data() const { return num_tdata_.load(std::memory_order_relaxed) > 0; }
  int port() const { return port_; }

  void Keep(const std::string& name, Bytes message);

  mutable std::mutex mutex;
  PoseServerStatus status;
  bool is_ok = true;
  bool has_status = false;  ///< It was set.
  std::string status_text = "ready";

 private:
  Bytes StatusMessage() const;
  void Greet(ServerClient& client);
  void Run();
  void AcceptAll();
  void Deliver(const Parcel& parcel);
  bool Listen(ServerClient& client);
  void Answer(ServerClient& client, const IgtlMessage& message);
  void SendAll();
  void CountClients();
  void Note(std::uint64_t PoseServerStatus::*count, const std::string& error);

  const PoseServerOptions options_;
  const std::int64_t utc_offset_ns_ = UtcOffsetNs();
  Descriptor listener_;
  std::atomic<int> port_{0};
  WakeUp wake_;
  std::thread thread_;
  std::atomic<bool> stopping_{true};  ///< Not running yet, or no longer.
  std::atomic<int> num_clients_{0}, num_tdata_{0};
  std::vector<Parcel> inbox_;                ///< Guarded by mutex.
  std::map<std::string, SharedBytes> kept_;  ///< Guarded by mutex.
  std::list<ServerClient> clients_;
  Bytes chunk_ = Bytes(64 * 1024);
};

void PoseServer::Network::Start() {
  if (thread_.joinable()) return;
  listener_ = ListenTcp(options_.host, port_ != 0 ? port_.load() : options_.port);
  port_ = PortOf(listener_);
  stopping_ = false;
  thread_ = std::thread([this] { Run(); });
}

void PoseServer::Network::Stop() noexcept {
  if (!thread_.joinable()) return;
  stopping_ = true;
  wake_.Ring();
  thread_.join();
  clients_.clear();
  listener_.Close();
  CountClients();
}

void PoseServer::Network::Post(Parcel parcel) {
  {
    const std::lock_guard lock(mutex);
    if (stopping_) return;
    inbox_.push_back(std::move(parcel));
  }
  wake_.Ring();
}

void PoseServer::Network::Run() {
  std::vector<pollfd> waits;
  std::vector<Parcel> parcels;
  while (!stopping_) {
    waits.assign({{.fd = wake_.fd(), .events = POLLIN, .revents = 0},
                  {.fd = listener_.get(), .events = POLLIN, .revents = 0}});
    for (const ServerClient& client : clients_) {
      const short out = client.has_waiting() ? POLLOUT : 0;
      waits.push_back(
          {.fd = client.socket().get(), .events = static_cast<short>(POLLIN | out), .revents = 0});
    }
    poll(waits.data(), waits.size(), 1000);
    wake_.Clear();
    std::size_t at = 2;
    for (auto client = clients_.begin(); client != clients_.end(); ++at) {
      const bool is_open =
          (waits[at].revents & (POLLIN | POLLERR | POLLHUP)) == 0 || Listen(*client);
      client = is_open ? std::next(client) : clients_.erase(client);
    }
    if ((waits[1].revents & POLLIN) != 0) AcceptAll();
    CountClients();
    {
      const std::lock_guard lock(mutex);
      parcels.swap(inbox_);
    }
    for (const Parcel& parcel : parcels) Deliver(parcel);
    parcels.clear();
    SendAll();
  }
}

void PoseServer::Network::AcceptAll() {
  for (Descriptor socket = AcceptTcp(listener_); socket.valid(); socket = AcceptTcp(listener_)) {
    if (static_cast<int>(clients_.size()) >= options_.max_clients) {
      Note(&PoseServerStatus::refused, "no place for " + PeerName(socket));
      continue;  // Closes.
    }
    clients_.emplace_back(std::move(socket), options_.max_backlog_bytes);
    Greet(clients_.back());
    Note(&PoseServerStatus::connects, "");
  }
}

/// Small things go before poses; large ones wait as images do, without counting as backlog.
void HandOver(ServerClient& client, const std::string& name, const SharedBytes& bytes) {
  if (bytes->size() <= kMaxUnreadBytes) return client.Add(bytes);
  client.AddImage(name, bytes);
}

/// @pre mutex is held.
Bytes PoseServer::Network::StatusMessage() const {
  return PackStatus(options_.name, UtcNs(MonotonicNs()), is_ok, status_text);
}

void PoseServer::Network::Greet(ServerClient& client) {
  const std::lock_guard lock(mutex);
  if (has_status) client.Add(Shared(StatusMessage()));
  for (const auto& [name, bytes] : kept_) HandOver(client, name, bytes);
}

void PoseServer::Network::Keep(const std::string& name, Bytes message) {
  const SharedBytes bytes = Shared(std::move(message));
  {
    const std::lock_guard lock(mutex);
    kept_[name] = bytes;
  }
  Post({.kind = Parcel::kKept, .bytes = bytes, .stream = name});
}

void PoseServer::Network::Deliver(const Parcel& parcel) {
  if (parcel.kind == Parcel::kDisconnect) clients_.clear();
  for (ServerClient& client : clients_) {
    if (parcel.kind == Parcel::kKept) {
      HandOver(client, parcel.stream, parcel.bytes);
    } else if (parcel.kind == Parcel::kImage) {
      if (client.AddImage(parcel.stream, parcel.bytes)) {
        Note(&PoseServerStatus::images_replaced, "");
      }
    } else if (parcel.kind == Parcel::kPoses && client.wants_tracking_data()) {
      // Null if the client asked between the packing of this set and now.
      if (parcel.tracking_data) client.AddTrackingData(parcel.tracking_data, parcel.time_ns);
    } else if (!parcel.bytes->empty()) {
      client.Add(parcel.bytes);
    }
  }
}

/// Takes what a client says. False: it is gone, or says nothing sensible.
bool PoseServer::Network::Listen(ServerClient& client) {
  const Transfer transfer = Receive(client.socket(), chunk_);
  if (transfer.state == TransferState::kClosed) return false;
  client.reader().Append(ByteView(chunk_).first(transfer.bytes));
  while (const auto message = client.reader().Next()) Answer(client, *message);
  if (client.reader().skipped_in_a_row() <= kMaxUnreadBytes) return true;
  Note(&PoseServerStatus::rubbish, client.peer() + " sent what is no OpenIGTLink message");
  return false;
}

void PoseServer::Network::Answer(ServerClient& client, const IgtlMessage& message) {
  const std::string& type = message.header.type;
  if (type == "STT_TDATA") {
    const auto interval_ms = ReadStartTrackingData(message.body.content);
    if (interval_ms) client.StartTrackingData(*interval_ms);
    client.Add(Shared(PackTrackingDataReply(options_.name, interval_ms.has_value())));
  } else if (type == "STP_TDATA") {
    client.StopTrackingData();
  } else if (type == "GET_STATUS") {
    const std::lock_guard lock(mutex);
    client.Add(Shared(StatusMessage()));
  } else if (type == "GET_CAPABIL") {
    client.Add(Shared(PackCapability(options_.name, kCapabilities)));
  }
}

void PoseServer::Network::SendAll() {
  for (auto client = clients_.begin(); client != clients_.end();) {
    bool is_open = client->SendWaiting();
    if (is_open && client->is_too_slow()) {
      Note(&PoseServerStatus::too_slow, client->peer() + " takes no poses; disconnected");
      is_open = false;
    }
    client = is_open ? std::next(client) : clients_.erase(client);
  }
  CountClients();
}

void PoseServer::Network::CountClients() {
  num_clients_ = static_cast<int>(clients_.size());
  num_tdata_ = static_cast<int>(
      std::count_if(clients_.begin(), clients_.end(),
                    [](const ServerClient& client) { return client.wants_tracking_data(); }));
  const std::lock_guard lock(mutex);
  status.clients = num_clients_;
}

void PoseServer::Network::Note(std::uint64_t PoseServerStatus::*count, const std::string& error) {
  const std::lock_guard lock(mutex);
  ++(status.*count);
  if (!error.empty()) status.last_error = error;
}

SharedBytes PoseServer::Network::TransformsOf(std::span<const NamedPose> poses,
                                              std::int64_t time_ns) const {
  Bytes all;
  for (const NamedPose& pose : poses) {
    if (!pose.valid && !options_.send_validity) continue;
    const Bytes one =
        options_.send_validity
            ? PackTransformWithStatus(pose.name, time_ns, pose.reference_from_tool, pose.valid)
            : PackTransform(pose.name, time_ns, pose.reference_from_tool);
    all.insert(all.end(), one.begin(), one.end());
  }
  return Shared(std::move(all));
}

SharedBytes PoseServer::Network::TrackingDataOf(std::span<const NamedPose> poses,
                                                std::int64_t time_ns) const {
  std::vector<std::pair<std::string, transforms::Pose>> seen;
  for (const NamedPose& pose : poses) {
    if (pose.valid) seen.emplace_back(pose.name, pose.reference_from_tool);
  }
  return Shared(PackTrackingData(options_.name, time_ns, seen));
}

PoseServer::PoseServer(PoseServerOptions options)
    : network_(std::make_unique<Network>(std::move(options))) {}

PoseServer::~PoseServer() {
  network_->Stop();
}

void PoseServer::Start() {
  network_->Start();
}

void PoseServer::Stop() noexcept {
  network_->Stop();
}

int PoseServer::port() const {
  return network_->port();
}

std::int64_t PoseServer::UtcNs(std::int64_t time_ns) const {
  return network_->UtcNs(time_ns);
}

PoseServerStatus PoseServer::status() const {
  const std::lock_guard lock(network_->mutex);
  return network_->status;
}

void PoseServer::SendPoses(std::span<const NamedPose> poses, std::int64_t time_ns) {
  {
    const std::lock_guard lock(network_->mutex);
    ++network_->status.pose_sets;
  }
  if (!network_->has_clients()) return;
  const std::int64_t utc_ns = network_->UtcNs(time_ns);
  Parcel parcel{.kind = Parcel::kPoses,
                .bytes = network_->TransformsOf(poses, utc_ns),
                .tracking_data = nullptr,
                .stream = {},
                .time_ns = time_ns};
  if (network_->wants_tracking_data()) {
    parcel.tracking_data = network_->TrackingDataOf(poses, utc_ns);
  }
  network_->Post(std::move(parcel));
}

void PoseServer::SendImage(const std::string& stream, const Image& image, std::int64_t time_ns) {
  {
    const std::lock_guard lock(network_->mutex);
    ++network_->status.images;
  }
  if (!network_->has_clients()) return;
  network_->Post({.kind = Parcel::kImage,
                  .bytes = Shared(PackImage(stream, network_->UtcNs(time_ns), image)),
                  .tracking_data = nullptr,
                  .stream = stream,
                  .time_ns = time_ns});
}

void PoseServer::SetStatus(bool ok, const std::string& text) {
  {
    const std::lock_guard lock(network_->mutex);
    network_->is_ok = ok;
    network_->has_status = true;
    network_->status_text = text;
  }
  network_->Post({.kind = Parcel::kForAll,
                  .bytes = Shared(PackStatus(network_->options().name,
                                             network_->UtcNs(MonotonicNs()), ok, text)),
                  .tracking_data = nullptr,
                  .stream = {},
                  .time_ns = 0});
}

void PoseServer::KeepPose(const NamedPose& pose) {
  network_->Keep(pose.name, PackTransform(pose.name, network_->UtcNs(MonotonicNs()),
                                          pose.reference_from_tool));
}

void PoseServer::KeepVolume(const std::string& name, const VolumeView& volume) {
  network_->Keep(name, PackVolume(name, network_->UtcNs(MonotonicNs()), volume));
}

void PoseServer::KeepPoints(const std::string& name, std::span<const NamedPoint> points) {
  network_->Keep(name, PackPoints(name, network_->UtcNs(MonotonicNs()), points));
}

void PoseServer::Disconnect() {
  network_->Post({.kind = Parcel::kDisconnect,
                  .bytes = Shared({}),
                  .tracking_data = nullptr,
                  .stream = {},
                  .time_ns = 0});
}

void PoseServer::SendRaw(std::span<const std::uint8_t> bytes) {
  network_->Post({.kind = Parcel::kForAll,
                  .bytes = Shared(Bytes(bytes.begin(), bytes.end())),
                  .tracking_data = nullptr,
                  .stream = {},
                  .time_ns = 0});
}

}  // namespace acus::tracking
