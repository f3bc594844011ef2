#include "viewer/imgui_layer.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <osgGA/GUIEventHandler>

#include "idl/clock.h"
#include "viewer/font.h"

namespace palp {
namespace {

using UiEvent = osgGA::GUIEventAdapter;

constexpr double kClickReach = 4;    // [pixels] that a click may move
constexpr int kKeyMask = 0x1ff;      // ImGui has a state for so many keys
constexpr double kLongestFrame = 1;  // [s] that ImGui is told of

int index_of(int key) { return key & kKeyMask; }

void name_keys(ImGuiIO& io) {
  const std::pair<ImGuiKey, int> keys[] = {{ImGuiKey_Tab, UiEvent::KEY_Tab},
                                           {ImGuiKey_LeftArrow, UiEvent::KEY_Left},
                                           {ImGuiKey_RightArrow, UiEvent::KEY_Right},
                                           {ImGuiKey_UpArrow, UiEvent::KEY_Up},
                                           {ImGuiKey_DownArrow, UiEvent::KEY_Down},
                                           {ImGuiKey_Home, UiEvent::KEY_Home},
                                           {ImGuiKey_End, UiEvent::KEY_End},
                                           {ImGuiKey_Delete, UiEvent::KEY_Delete},
                                           {ImGuiKey_Backspace, UiEvent::KEY_BackSpace},
                                           {ImGuiKey_Enter, UiEvent::KEY_Return},
                                           {ImGuiKey_KeyPadEnter, UiEvent::KEY_KP_Enter},
                                           {ImGuiKey_Escape, UiEvent::KEY_Escape},
                                           {ImGuiKey_Space, UiEvent::KEY_Space},
                                           {ImGuiKey_A, 'a'},
                                           {ImGuiKey_C, 'c'},
                                           {ImGuiKey_V, 'v'},
                                           {ImGuiKey_X, 'x'},
                                           {ImGuiKey_Y, 'y'},
                                           {ImGuiKey_Z, 'z'}};
  for (const auto& [name, key] : keys) io.KeyMap[name] = index_of(key);
}

// Returns the letter that a key writes, or 0.
unsigned letter_of(int key) {
  if (key >= UiEvent::KEY_KP_0 && key <= UiEvent::KEY_KP_9) return static_cast<unsigned>('0' + key - UiEvent::KEY_KP_0);
  if (key == UiEvent::KEY_KP_Decimal) return '.';
  if (key == UiEvent::KEY_KP_Subtract) return '-';
  return (key >= 0x20 && key < 0x7f) || (key >= 0xa0 && key < 0x100) ? static_cast<unsigned>(key) : 0;
}

int button_of(const UiEvent& event) {
  switch (event.getButton()) {
    case UiEvent::LEFT_MOUSE_BUTTON:
      return ImGuiMouseButton_Left;
    case UiEvent::RIGHT_MOUSE_BUTTON:
      return ImGuiMouseButton_Right;
    case UiEvent::MIDDLE_MOUSE_BUTTON:
      return ImGuiMouseButton_Middle;
    default:
      return -1;
  }
}

}  // namespace

// Stands first among the handlers, so that the camera and the keys get only what no window wants.
class ImguiLayer::Events : public osgGA::GUIEventHandler {
 public:
  Events(const Stage& stage, ImGuiContext* context) : stage_(stage), context_(context) {}

  bool handle(const UiEvent& event, osgGA::GUIActionAdapter& /*unused*/, osg::Object* /*unused*/,
              osg::NodeVisitor* /*unused*/) override {
    if (context_ == nullptr) return false;
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    switch (event.getEventType()) {
      case UiEvent::MOVE:
      case UiEvent::DRAG:
        note_place(event, io);
        return io.WantCaptureMouse;
      case UiEvent::PUSH:
      case UiEvent::DOUBLECLICK:
        note_place(event, io);
        return push(event, io);
      case UiEvent::RELEASE:
        note_place(event, io);
        return release(event, io);
      case UiEvent::SCROLL:
        io.MouseWheel += event.getScrollingMotion() == UiEvent::SCROLL_UP     ? 1.0f
                         : event.getScrollingMotion() == UiEvent::SCROLL_DOWN ? -1.0f
                                                                              : 0.0f;
        return io.WantCaptureMouse;
      case UiEvent::KEYDOWN:
      case UiEvent::KEYUP:
        return key(event, io);
      default:
        return false;
    }
  }

  void close() { context_ = nullptr; }
  std::vector<osg::Vec2d> take_clicks() { return std::exchange(clicks_, {}); }

 private:
  void note_place(const UiEvent& event, ImGuiIO& io) {
    place_.set(0.5 * (event.getXnormalized() + 1) * stage_.width(),
               0.5 * (event.getYnormalized() + 1) * stage_.height());
    io.MousePos = ImVec2(static_cast<float>(place_.x()), static_cast<float>(stage_.height() - place_.y()));
  }

  bool push(const UiEvent& event, ImGuiIO& io) {
    const int button = button_of(event);
    if (button >= 0) io.MouseDown[button] = true;
    may_click_ = button == ImGuiMouseButton_Left && !io.WantCaptureMouse;
    pushed_at_ = place_;
    return io.WantCaptureMouse;
  }

  bool release(const UiEvent& event, ImGuiIO& io) {
    const int button = button_of(event);
    if (button >= 0) io.MouseDown[button] = false;
    if (may_click_ && button == ImGuiMouseButton_Left && (place_ - pushed_at_).length() <= kClickReach)
      clicks_.push_back(place_);
    may_click_ = false;
    return io.WantCaptureMouse;
  }

  bool key(const UiEvent& event, ImGuiIO& io) {
    const bool down = event.getEventType() == UiEvent::KEYDOWN;
    io.KeysDown[index_of(event.getKey())] = down;
    io.KeyCtrl = (event.getModKeyMask() & UiEvent::MODKEY_CTRL) != 0;
    io.KeyShift = (event.getModKeyMask() & UiEvent::MODKEY_SHIFT) != 0;
    io.KeyAlt = (event.getModKeyMask() & UiEvent::MODKEY_ALT) != 0;
    if (!io.WantCaptureKeyboard) return false;
    if (const unsigned letter = letter_of(event.getKey()); down && letter != 0 && !io.KeyCtrl)
      io.AddInputCharacter(letter);
    return true;
  }

  const Stage& stage_;
  ImGuiContext* context_;
  osg::Vec2d place_, pushed_at_;
  bool may_click_ = false;
  std::vector<osg::Vec2d> clicks_;
};

ImguiLayer::ImguiLayer(Stage& stage, std::function<void()> build, bool in_pictures)
    : stage_(stage), build_(std::move(build)), context_(ImGui::CreateContext()) {
  ImGui::SetCurrentContext(context_);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // what is remembered is in settings.h
  io.LogFilename = nullptr;
  io.BackendPlatformName = "palp";
  name_keys(io);
  set_theme(Theme::dark);
  events_ = new Events(stage, context_);
  stage_.viewer().getEventHandlers().push_front(events_);
  stage_.set_overlay([this] { draw(); }, in_pictures);
}

ImguiLayer::~ImguiLayer() {
  stage_.set_overlay({}, false);
  events_->close();
  stage_.viewer().removeEventHandler(events_);
  ImGui::SetCurrentContext(context_);
  if (started_) {
    osg::GraphicsContext* window = stage_.viewer().getCamera()->getGraphicsContext();
    const bool current = window->makeCurrent();
    ImGui_ImplOpenGL3_Shutdown();
    if (current) window->releaseContext();
  }
  ImGui::DestroyContext(context_);
}

void ImguiLayer::set_font_size(float pixels) { font_size_ = std::round(std::clamp(pixels, 6.0f, 80.0f)); }

void ImguiLayer::set_theme(Theme theme) {
  ImGui::SetCurrentContext(context_);
  theme == Theme::light ? ImGui::StyleColorsLight() : ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = style.WindowBorderSize = 0;
  style.FrameRounding = style.GrabRounding = 3;
  style.Colors[ImGuiCol_WindowBg].w = style.Colors[ImGuiCol_MenuBarBg].w = 0.92f;
}

std::vector<osg::Vec2d> ImguiLayer::take_clicks() { return events_->take_clicks(); }

void ImguiLayer::load_font() {
  loaded_font_size_ = font_size_;
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  // Latin, Greek, general punctuation: what names of scenes and units are likely to hold
  static const ImWchar kGlyphs[] = {0x20, 0x24f, 0x370, 0x3ff, 0x2010, 0x2027, 0x2190, 0x2193, 0};
  const std::string file = find_font_file();
  if (file.empty() || atlas.AddFontFromFileTTF(file.c_str(), font_size_, nullptr, kGlyphs) == nullptr) {
    ImFontConfig plain;
    plain.SizePixels = font_size_;
    atlas.AddFontDefault(&plain);
  }
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
  const float em = font_size_;
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowPadding = ImVec2(0.6f * em, 0.5f * em);
  style.FramePadding = ImVec2(0.35f * em, 0.2f * em);
  style.ItemSpacing = ImVec2(0.5f * em, 0.3f * em);
  style.ItemInnerSpacing = ImVec2(0.35f * em, 0.3f * em);
  style.ScrollbarSize = 0.8f * em;
  style.GrabMinSize = 0.7f * em;
  style.IndentSpacing = em;
}

void ImguiLayer::draw() {
  ImGui::SetCurrentContext(context_);
  if (!started_) {
    started_ = ImGui_ImplOpenGL3_Init("#version 130");
    if (!started_) return;
    ImGui_ImplOpenGL3_NewFrame();
  }
  if (loaded_font_size_ != font_size_) load_font();
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(static_cast<float>(stage_.width()), static_cast<float>(stage_.height()));
  const double now = 1e-9 * static_cast<double>(now_ns());
  io.DeltaTime = static_cast<float>(std::clamp(now - std::exchange(drawn_at_, now), 1e-4, kLongestFrame));
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  build_();
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace palp
