// What a person does at a window, injected through the X server (XTEST) by xdotool.
#pragma once

#include <cstdlib>
#include <string>

namespace acus::testing_support {

/// The window is the only one of its display and at its upper left corner, so that keys go to it
/// while the pointer is in it.
class WindowInput {
 public:
  WindowInput() { Point(200, 150); }
  void Point(int column, int row) {
    Run("mousemove " + std::to_string(column) + " " + std::to_string(row));
  }
  void Key(const std::string& name) { Run("key " + name); }
  void KeyDown(const std::string& name) { Run("keydown " + name); }
  void KeyUp(const std::string& name) { Run("keyup " + name); }
  void Button(int number) { Run("click " + std::to_string(number)); }
  void ButtonDown(int number) { Run("mousedown " + std::to_string(number)); }
  void ButtonUp(int number) { Run("mouseup " + std::to_string(number)); }

 private:
  static void Run(const std::string& action) {
    std::string command = "xdotool ";
    command.append(action).append(" >/dev/null 2>&1");
    if (std::system(command.c_str()) != 0) std::abort();
  }
};

}  // namespace acus::testing_support
