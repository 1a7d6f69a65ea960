// An X server without a screen, for tests of windows.
#pragma once

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace acus::testing_support {

/// Starts Xvfb on a display number that is free, and sets DISPLAY; ends it in the destructor.
class VirtualDisplay {
 public:
  VirtualDisplay(int width_px, int height_px) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    const std::string screen = std::to_string(width_px) + "x" + std::to_string(height_px) + "x24";
    const std::string fd = std::to_string(ends[1]);
    child_ = fork();
    if (child_ == 0) {
      close(ends[0]);
      execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", screen.c_str(), "-noreset",
             "-nolisten", "tcp", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    std::string number;
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) number += c;
    close(ends[0]);
    if (number.empty()) throw std::runtime_error("Xvfb does not start: is package xvfb there?");
    setenv("DISPLAY", (":" + number).c_str(), 1);
  }
  ~VirtualDisplay() {
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
  }
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

 private:
  pid_t child_ = -1;
};

}  // namespace acus::testing_support
