// The bar below the views: what happened, forces, latency; and the page of keys.
#pragma once

#include "display/frame.h"
#include "display/layout.h"
#include "display/marks.h"
#include "display/sketch.h"
#include "display/steering.h"

namespace acus::display {

Colour ColourOf(Severity severity) noexcept;

void DrawStatusBar(const DisplayFrame& frame, const ViewChoice& choice, const Rectangle& place,
                   const TextSizes& sizes, Sketch& sketch);

/// Over all views.
void DrawHelp(const Rectangle& window, const TextSizes& sizes, Sketch& sketch);

}  // namespace acus::display
