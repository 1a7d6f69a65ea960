// Poses from any OpenIGTLink peer: PLUS, a tracker's own server, 3D Slicer.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "acus/rig/tracking/image.h"
#include "acus/rig/tracking/pose_source.h"

namespace acus::tracking {

/// A tool that is required, and how to find it in what the peer sends.
struct IgtlTool {
  std::string tool = {};    ///< Our name: "probe".
  std::string device = {};  ///< Name in the messages: "ProbeToReference". Its first 20 characters.
  /// Empty: `device` gives reference_from_marker. Else the name of another transform into the same
  /// frame, such as "ReferenceToTracker" where `device` is "ProbeToTracker".
  std::string relative_to = {};
  /// Calibration: reference_from_tool = reference_from_marker * marker_from_tool.
  Eigen::Isometry3d marker_from_tool = Eigen::Isometry3d::Identity();
};

struct IgtlOptions {
  std::string name = "tracker";  ///< For messages to the user.
  std::string host = "localhost";
  int port = 18944;  ///< The protocol's usual port.
  /// We wait for the peer to connect to us, for trackers that are clients. Port 0 is a free one.
  bool listen = false;
  std::vector<IgtlTool> tools = {};
  /// Request TDATA (STT_TDATA) at this least interval; 0 as fast as can be; negative: do not ask.
  int tdata_interval_ms = -1;
  bool check_crc = true;
  bool keep_images = false;  ///< Images are kept for Image().
  /// A tool without a reading for so long is published as not seen: PLUS by default does not send
  /// transforms of tools that it does not see.
  int lost_after_ms = 200;
  /// A silent link is opened again after this.
  int silence_ms = 10'000;
  /// A message must be complete within this: a peer that trickles is disconnected.
  int message_ms = 2'000;
  std::size_t journal_capacity = 0;  ///< Of the board.
};

/// The newest image of a stream.
struct ReceivedImage {
  std::int64_t time_ns = 0;         ///< Arrival, MonotonicNs().
  std::int64_t source_time_ns = 0;  ///< The sender's stamp; 0 if there is none.
  std::uint64_t number = 0;         ///< Images of this stream so far.
  Image image = {};
};

/// One thread receives, and connects again by itself (100 ms after a loss, then doubling to 2 s;
/// from the start again once messages came). Whatever the peer sends, the thread continues: see
/// IgtlReader. Everything that is not published is counted in status().
class IgtlSource final : public PoseSource {
 public:
  /// @throws InputError if a tool's name or device is empty or there twice, or a number is out of
  ///     range.
  explicit IgtlSource(IgtlOptions options);
  ~IgtlSource() override;

  std::string name() const override;
  /// @throws InputError if it is to listen and the port is taken.
  void Start() override;
  void Stop() noexcept override;
  PoseBoard& board() noexcept override;
  SourceStatus status() const override;

  /// The port that is listened on, after Start().
  int port() const;
  /// The newest image of a stream, or of any for ""; null before the first.
  std::shared_ptr<const ReceivedImage> Image(const std::string& device) const;

 private:
  class Receiver;
  std::unique_ptr<Receiver> receiver_;
};

}  // namespace acus::tracking
