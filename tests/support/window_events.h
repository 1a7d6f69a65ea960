// Messages of a window manager, for windows of tests.
#pragma once

#include <string>

namespace acus::testing_support {

/// As the button that closes a window does. False if there is no window of that title.
bool AskToClose(const std::string& title);
/// As a dragged corner does.
bool ResizeWindow(const std::string& title, int width_px, int height_px);

}  // namespace acus::testing_support
