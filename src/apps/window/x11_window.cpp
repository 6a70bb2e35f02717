#include "apps/window/x11_window.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <algorithm>
#include <cstdlib>

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

/** Where the 8 bits of a colour go in a pixel. */
int shiftOf(unsigned long mask) {
  int shift = 0;
  for (; mask != 0 && (mask & 1) == 0; mask >>= 1)
    ++shift;
  return shift;
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
    red = shiftOf(visual->red_mask);
    green = shiftOf(visual->green_mask);
    blue = shiftOf(visual->blue_mask);
    XStoreName(d, window, title.c_str());
    XSelectInput(d, window, ExposureMask | StructureNotifyMask);
    closed = XInternAtom(d, "WM_DELETE_WINDOW", False);
    XSetWMProtocols(d, window, &closed, 1);
    XMapWindow(d, window);
    XFlush(d);
  }

  /** Nearest pixels; the rest of the window is black. */
  void scale() {
    pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    const double share =
        std::min(static_cast<double>(width) / picture_width, static_cast<double>(height) / picture_height);
    const int w = std::clamp(static_cast<int>(picture_width * share + 0.5), 1, width);
    const int h = std::clamp(static_cast<int>(picture_height * share + 0.5), 1, height);
    const int left = (width - w) / 2, top = (height - h) / 2;
    for (int v = 0; v < h; ++v) {
      const std::uint8_t* row = rgb.data() + 3LL * picture_width * (static_cast<long long>(v) * picture_height / h);
      std::uint32_t* out = pixels.data() + static_cast<std::ptrdiff_t>(top + v) * width + left;
      for (int u = 0; u < w; ++u) {
        const std::uint8_t* p = row + 3LL * (static_cast<long long>(u) * picture_width / w);
        out[u] = static_cast<std::uint32_t>(p[0]) << red | static_cast<std::uint32_t>(p[1]) << green |
                 static_cast<std::uint32_t>(p[2]) << blue;
      }
    }
  }

  void paint() {
    if (rgb.empty() || width < 1 || height < 1) return;
    scale();
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
  int depth{}, red{}, green{}, blue{};
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
