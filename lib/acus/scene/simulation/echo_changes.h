// What effects do to the echoes of a B-mode image: fluid that is darker than the tissue it lies in,
// gas that shadows what is behind.
#pragma once

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/snapshot.h"

namespace acus::simulation {

/// Changes the greys of a finished image as the effects of the list say, each dB by the share of
/// the probe's dynamic range: to black below it, to white above. Pixels beyond the probe's field
/// stay. Does nothing if no effect changes echoes at this moment. Allocates nothing.
/// @param probe  As the image was made with. @param geometry  Of the image.
void ChangeEchoes(const Scene& scene, const Snapshot& snapshot, const acoustics::Probe& probe,
                  const image::ImageGeometry& geometry, image::GrayImage& image) noexcept;

}  // namespace acus::simulation
