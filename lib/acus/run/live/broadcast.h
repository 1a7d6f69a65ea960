// A live session for others to watch: an OpenIGTLink server of tools, images, patient and status.
#pragma once

#include <string>

#include "acus/data/transforms/landmarks.h"
#include "acus/rig/tracking/pose_server.h"
#include "acus/run/live/image_thread.h"
#include "acus/run/live/live_devices.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

/// Sent once to every client that connects, where the scene has it:
///   TRANSFORM ReferenceToRas   ct_from_reference, then to RAS
///   TRANSFORM TargetToRas      only a translation
///   POINT     Targets          all targets, RAS, mm
///   IMAGE     CT, Labels       RAS: the CT in HU, label numbers
///   STATUS    Acus             what the screen says first; again when it changes
/// With every image:
///   TRANSFORM ProbeToReference, NeedleToReference   of tools that are seen
///   IMAGE     Ultrasound       where the probe was; its matrix is ImageToReference
class Broadcast {
 public:
  /// Listens at once. @param scene  Outlives this.
  /// @param targets  Points in CT space; the last is where the tip is to go.
  /// @throws InputError if the port is taken.
  Broadcast(const SendOut& where, const simulation::Scene& scene,
            const transforms::Landmarks& targets, bool has_probe);

  /// Hands over and returns: no watcher delays the caller. For one thread.
  void Send(const LiveImage& image);
  /// Sent if it is another than the last. For one thread.
  void SetStatus(bool is_ok, const std::string& text);
  void Stop() noexcept { server_.Stop(); }
  int port() const { return server_.port(); }

 private:
  const simulation::Scene& scene_;
  bool has_probe_;
  std::string status_;
  tracking::PoseServer server_;
};

/// Listens for an instant: whether a session could. @throws InputError if the port is taken.
void RequirePortFree(const SendOut& where);

}  // namespace acus::live
