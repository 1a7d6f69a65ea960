// Sends a live session to watchers: an OpenIGTLink server of tools, images, patient and status.
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
///   STATUS    Acus             the first status line; again when it changes
/// With every image:
///   TRANSFORM ProbeToReference, NeedleToReference   of visible tools
///   IMAGE     Ultrasound       at the probe; its matrix is ImageToReference
class Broadcast {
 public:
  /// Listens at once. @param scene  Outlives this.
  /// @param targets  Points in CT space; the last is the target of the tip.
  /// @throws InputError if the port is taken.
  Broadcast(const SendOut& where, const simulation::Scene& scene,
            const transforms::Landmarks& targets, bool has_probe);

  /// Hands over and returns: no watcher delays the caller. For one thread.
  void Send(const LiveImage& image);
  /// Sends the status if it differs from the last one. For one thread.
  void SetStatus(bool is_ok, const std::string& text);
  void Stop() noexcept { server_.Stop(); }
  int port() const { return server_.port(); }

 private:
  const simulation::Scene& scene_;
  bool has_probe_;
  std::string status_;
  tracking::PoseServer server_;
};

/// Tests whether a session could listen. @throws InputError if the port is taken.
void RequirePortFree(const SendOut& where);

}  // namespace acus::live
