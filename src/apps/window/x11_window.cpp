#include "apps/window/x11_window.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <cstdlib>

#include "apps/window/window_pixels.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

constexpr int kFirstWidth = 640, kFirstHeight = 360;  // [px] before the first picture

struct CloseDisplay {
  void operator()(Display* display) const { XCloseDisplay(display); }
};

Display* openDisplay() {
  const char* name = std::getenv("DISPLAY");
  if (name == nullptr || *name == '\0') throw Exception("no display: DISPLAY is not set, there is nowhere to show it");
  Display* display = XOpenDisplay(nullptr);
  if (display == nullptr) throw Exception(std::string("no display: ") + name + " does not answer");
  return display;
}

bool hasLeast(const XWindowAttributes& a) {
  return a.visual->c_class == TrueColor && a.depth >= 24;
}

}  // namespace

struct X11Window::Impl {
  explicit Impl(const std::string& title) : display(openDisplay()) {
    Display* d = display.get();
    const int screen = DefaultScreen(d);
    window = XCreateSimpleWindow(d, DefaultRootWindow(d), 0, 0, kFirstWidth, kFirstHeight, 0, BlackPixel(d, screen),
                                 BlackPixel(d, screen));
    XWindowAttributes attributes;
    XGetWindowAttributes(d, window, &attributes);
    if (!hasLeast(attributes)) throw Exception("the display has less than 24 bits a pixel");
    visual = attributes.visual;
    depth = attributes.depth;
    layout = {shiftOf(visual->red_mask), shiftOf(visual->green_mask), shiftOf(visual->blue_mask)};
    XStoreName(d, window, title.c_str());
    XSelectInput(d, window, ExposureMask | StructureNotifyMask);
    closed = XInternAtom(d, "WM_DELETE_WINDOW", False);
    XSetWMProtocols(d, window, &closed, 1);
    XMapWindow(d, window);
    XFlush(d);
  }

  void paint() {
    if (rgb.empty() || width < 1 || height < 1) return;
    drawFitted(rgb, picture_width, picture_height, layout, width, height, &pixels);
    Display* d = display.get();
    XImage* image =
        XCreateImage(d, visual, static_cast<unsigned>(depth), ZPixmap, 0, reinterpret_cast<char*>(pixels.data()),
                     static_cast<unsigned>(width), static_cast<unsigned>(height), 32, width * 4);
    if (image == nullptr) return;
    const std::uint32_t one = 1;
    image->byte_order = *reinterpret_cast<const std::uint8_t*>(&one) == 1 ? LSBFirst : MSBFirst;  // as we write them
    XPutImage(d, window, DefaultGC(d, DefaultScreen(d)), image, 0, 0, 0, 0, static_cast<unsigned>(width),
              static_cast<unsigned>(height));
    image->data = nullptr;  // ours
    XDestroyImage(image);
    XFlush(d);
  }

  bool handle(const XEvent& event) {
    if (event.type == ConfigureNotify) {
      width = event.xconfigure.width;
      height = event.xconfigure.height;
    }
    const bool is_close = event.type == ClientMessage && static_cast<Atom>(event.xclient.data.l[0]) == closed;
    return !is_close && event.type != DestroyNotify;
  }

  std::unique_ptr<Display, CloseDisplay> display;
  Window window{};
  Visual* visual{};
  Atom closed{};
  int depth{};
  PixelLayout layout;
  int width{kFirstWidth}, height{kFirstHeight};  // of the window
  int picture_width{}, picture_height{};
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint32_t> pixels;
};

X11Window::X11Window(const std::string& title) : impl_(std::make_unique<Impl>(title)) {}

X11Window::~X11Window() = default;

void X11Window::show(const std::vector<std::uint8_t>& rgb, int width, int height) {
  if (width < 1 || height < 1 || rgb.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3)
    return;
  Impl& s = *impl_;
  if (s.rgb.empty()) {
    XResizeWindow(s.display.get(), s.window, static_cast<unsigned>(width), static_cast<unsigned>(height));
    s.width = width;
    s.height = height;
  }
  s.rgb = rgb;
  s.picture_width = width;
  s.picture_height = height;
  s.paint();
}

void X11Window::setTitle(const std::string& title) {
  XStoreName(impl_->display.get(), impl_->window, title.c_str());
  XFlush(impl_->display.get());
}

bool X11Window::handleEvents() {
  Impl& s = *impl_;
  bool is_open = true, is_old = false;
  while (XPending(s.display.get()) > 0) {
    XEvent event;
    XNextEvent(s.display.get(), &event);
    is_open = s.handle(event) && is_open;
    is_old = is_old || event.type == Expose || event.type == ConfigureNotify;
  }
  if (is_open && is_old) s.paint();
  return is_open;
}

}  // namespace raven2_trainer::apps
