// Poses, images and status for whoever watches: 3D Slicer, PLUS, our own client.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acus/data/transforms/pose.h"
#include "acus/rig/tracking/image.h"

namespace acus::tracking {

struct NamedPose {
  std::string name = {};  ///< "ProbeToReference"; its first 20 characters are sent.
  transforms::Pose reference_from_tool = {};
  bool valid = true;
};

struct PoseServerOptions {
  std::string name = "Acus";  ///< Device name of TDATA, STATUS and CAPABILITY.
  /// Address of this machine to listen on: "localhost" is heard here only, "" by all of the
  /// network.
  std::string host = "localhost";
  int port = 18944;  ///< 0 chooses a free one.
  /// Protocol 3 with PLUS's metadata, which can say that a tool is not seen. Without it (protocol
  /// 2, which older receivers need) the transform of a tool that is not seen is not sent, as PLUS
  /// does by default.
  bool send_validity = false;
  int max_clients = 16;
  /// Poses that a client does not take pile up; beyond this it is disconnected.
  std::size_t max_backlog_bytes = 4 * 1024 * 1024;
};

struct PoseServerStatus {
  int clients = 0;
  std::uint64_t connects = 0;
  std::uint64_t pose_sets = 0;        ///< SendPoses() calls.
  std::uint64_t images = 0;           ///< SendImage() calls.
  std::uint64_t images_replaced = 0;  ///< Not sent to a client because a newer one came first.
  std::uint64_t too_slow = 0;         ///< Clients that were disconnected for taking no poses.
  std::uint64_t refused = 0;          ///< Clients beyond max_clients.
  std::uint64_t rubbish = 0;          ///< Clients that were disconnected for what they sent.
  std::string last_error = {};
};

/// An OpenIGTLink server. On connecting a client gets the status, if one was set, and what is kept
/// for all: a CT, a target. Every client gets TRANSFORM messages of all tools; one that requests
/// TDATA (STT_TDATA) gets these instead, at the interval it requested, until STP_TDATA. GET_STATUS
/// and GET_CAPABIL are answered.
///
/// One thread does the network. Sending hands over and returns: a slow client delays no other. Of
/// images that a client has not taken the newest of each stream waits, older ones are counted;
/// poses are never omitted, they go before images, and a client that takes none is disconnected.
///
/// All methods can be called from any thread but take a short lock and allocate: not for the loop
/// that feels forces.
class PoseServer {
 public:
  explicit PoseServer(PoseServerOptions options);
  ~PoseServer();  ///< Stops.
  PoseServer(const PoseServer&) = delete;
  PoseServer& operator=(const PoseServer&) = delete;

  /// @throws InputError if the port is taken.
  void Start();
  /// Closes all links and the port. Start() opens the same port again, also if it was chosen.
  void Stop() noexcept;
  int port() const;
  /// MonotonicNs() as UTC, as it is sent.
  std::int64_t UtcNs(std::int64_t time_ns) const;
  PoseServerStatus status() const;

  /// The tools at one instant. @param time_ns  MonotonicNs() of the measurement; sent as UTC.
  void SendPoses(std::span<const NamedPose> poses, std::int64_t time_ns);
  /// @pre image is of 1 to 65535 pixels a side, with 1 or 3 channels.
  void SendImage(const std::string& stream, const Image& image, std::int64_t time_ns);
  /// Sent at once to all, to whoever connects, and to whoever asks.
  void SetStatus(bool ok, const std::string& text);

  /// What does not change: every client gets it once, on connecting or at once. Of one name the
  /// last counts. A volume is kept as its message, beside the caller's voxels.
  void KeepPose(const NamedPose& pose);
  void KeepVolume(const std::string& name, const VolumeView& volume);
  void KeepPoints(const std::string& name, std::span<const NamedPoint> points);

  /// Closes all links, which clients may open again. (A fault, for tests of what is fed.)
  void Disconnect();
  /// Sends bytes as they are, between messages. (A fault.)
  void SendRaw(std::span<const std::uint8_t> bytes);

 private:
  class Network;
  std::unique_ptr<Network> network_;
};

}  // namespace acus::tracking
