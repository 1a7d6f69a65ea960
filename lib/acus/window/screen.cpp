#include "acus/window/screen.h"

#include <GL/gl.h>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>
#include <vtkUnsignedCharArray.h>

#include "acus/window/x_display.h"

namespace acus::window {
namespace {

using Kind = InputEvent::Kind;

std::optional<InputEvent> EventOf(unsigned long event) {
  const auto button = [](Kind kind, int number) {
    InputEvent out;
    out.kind = kind;
    out.button = number;
    return out;
  };
  switch (event) {
    case vtkCommand::KeyPressEvent:
      return button(Kind::kKeyDown, 0);
    case vtkCommand::KeyReleaseEvent:
      return button(Kind::kKeyUp, 0);
    case vtkCommand::MouseMoveEvent:
      return button(Kind::kMove, 0);
    case vtkCommand::LeftButtonPressEvent:
      return button(Kind::kButtonDown, 1);
    case vtkCommand::MiddleButtonPressEvent:
      return button(Kind::kButtonDown, 2);
    case vtkCommand::RightButtonPressEvent:
      return button(Kind::kButtonDown, 3);
    case vtkCommand::LeftButtonReleaseEvent:
      return button(Kind::kButtonUp, 1);
    case vtkCommand::MiddleButtonReleaseEvent:
      return button(Kind::kButtonUp, 2);
    case vtkCommand::RightButtonReleaseEvent:
      return button(Kind::kButtonUp, 3);
    case vtkCommand::MouseWheelForwardEvent:
      return button(Kind::kWheelForward, 0);
    case vtkCommand::MouseWheelBackwardEvent:
      return button(Kind::kWheelBackward, 0);
    case vtkCommand::ExitEvent:
      return button(Kind::kClose, 0);
    default:
      return std::nullopt;
  }
}

}  // namespace

struct Screen::Content {
  XConnection connection;  ///< Must outlive the window.
  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkRenderWindowInteractor> interactor;
  vtkNew<vtkCallbackCommand> callback;
  vtkNew<vtkUnsignedCharArray> pixels;
  std::vector<InputEvent> events;
  int height_px = 0;  ///< Height at the time of the events.

  static void OnEvent(vtkObject* caller, unsigned long event, void* self, void* /*data*/) {
    auto* content = static_cast<Content*>(self);
    auto* from = static_cast<vtkRenderWindowInteractor*>(caller);
    std::optional<InputEvent> out = EventOf(event);
    if (!out) return;
    const int* place = from->GetEventPosition();
    out->column = place[0];
    out->row = content->window->GetSize()[1] - 1 - place[1];
    out->shift = from->GetShiftKey() != 0;
    if (out->kind == Kind::kKeyDown || out->kind == Kind::kKeyUp) {
      const char* symbol = from->GetKeySym();
      out->key = symbol == nullptr ? "" : symbol;
    }
    content->events.push_back(std::move(*out));
  }
};

Screen::Screen(const std::string& title, int width_px, int height_px)
    : content_(std::make_unique<Content>()) {
  vtkRenderWindow& window = *content_->window;
  window.SetDisplayId(content_->connection.display());
  window.SetWindowName(title.c_str());
  window.SetSize(width_px, height_px);
  window.SetMultiSamples(0);
  window.StereoCapableWindowOn();  // A request; VTK cancels it if the driver has none.
  window.SetNumberOfLayers(kNumLayers);
  content_->interactor->SetRenderWindow(&window);
  content_->interactor->SetInteractorStyle(nullptr);  // VTK's style has an exit key.
  content_->callback->SetCallback(&Content::OnEvent);
  content_->callback->SetClientData(content_.get());
  content_->interactor->AddObserver(vtkCommand::AnyEvent, content_->callback);
  window.Render();
  content_->interactor->Initialize();
}

Screen::~Screen() {
  content_->interactor->RemoveObserver(content_->callback);
  content_->window->Finalize();
}

void Screen::Add(vtkRenderer* renderer, int layer) {
  renderer->SetLayer(layer);
  content_->window->AddRenderer(renderer);
}

void Screen::Remove(vtkRenderer* renderer) {
  content_->window->RemoveRenderer(renderer);
}

std::vector<InputEvent> Screen::TakeEvents() {
  content_->interactor->ProcessEvents();
  std::vector<InputEvent> out;
  std::swap(out, content_->events);
  return out;
}

bool Screen::HasHeldKeys() const {
  const auto id = reinterpret_cast<std::uintptr_t>(content_->window->GetGenericWindowId());
  return content_->connection.HasHeldKeys(id);
}

void Screen::Render() {
  content_->window->Render();
}

bool Screen::has_shutter() const {
  return content_->window->GetStereoCapableWindow() != 0;
}

void Screen::SetStereo(Stereo stereo) {
  vtkRenderWindow& window = *content_->window;
  const bool is_shutter = stereo == Stereo::kShutter && has_shutter();
  if (is_shutter) {
    window.SetStereoTypeToCrystalEyes();
  } else {
    window.SetStereoTypeToAnaglyph();
  }
  window.SetStereoRender(is_shutter || stereo == Stereo::kRedCyan ? 1 : 0);
}

int Screen::width_px() const {
  return content_->window->GetSize()[0];
}
int Screen::height_px() const {
  return content_->window->GetSize()[1];
}

namespace {

/// VTK renders both eyes into its own buffer before the driver receives them.
/// False without SetStereo(kShutter).
bool ReadEye(EyeSide eye, vtkRenderWindow& window, vtkUnsignedCharArray& pixels) {
  auto* gl_window = vtkOpenGLRenderWindow::SafeDownCast(&window);
  if (gl_window == nullptr || window.GetStereoRender() == 0) return false;
  vtkOpenGLFramebufferObject& drawn = *gl_window->GetDisplayFramebuffer();
  if (window.GetStereoType() != VTK_STEREO_CRYSTAL_EYES ||
      drawn.GetNumberOfColorAttachments() < 2) {
    return false;
  }
  const int* size = window.GetSize();
  pixels.SetNumberOfComponents(3);
  pixels.SetNumberOfTuples(static_cast<vtkIdType>(size[0]) * size[1]);
  window.MakeCurrent();
  drawn.Bind(vtkOpenGLFramebufferObject::GetReadMode());
  drawn.ActivateReadBuffer(eye == EyeSide::kLeft ? 0 : 1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size[0], size[1], GL_RGB, GL_UNSIGNED_BYTE, pixels.GetPointer(0));
  drawn.UnBind(vtkOpenGLFramebufferObject::GetReadMode());
  return true;
}

}  // namespace

image::ColourImage Screen::Screenshot(EyeSide eye) {
  image::ColourImage out;
  out.Resize(width_px(), height_px());
  if (!ReadEye(eye, *content_->window, *content_->pixels)) {
    content_->window->GetPixelData(0, 0, out.width - 1, out.height - 1, /*front=*/0,
                                   content_->pixels);
  }
  const auto row_bytes = static_cast<std::size_t>(3 * out.width);
  if (content_->pixels->GetNumberOfValues() < static_cast<vtkIdType>(out.rgb.size())) return out;
  for (int row = 0; row < out.height; ++row) {
    std::memcpy(out.rgb.data() + static_cast<std::size_t>(out.height - 1 - row) * row_bytes,
                content_->pixels->GetPointer(0) + static_cast<std::size_t>(row) * row_bytes,
                row_bytes);
  }
  return out;
}

}  // namespace acus::window
