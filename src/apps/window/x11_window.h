#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace raven2_trainer::apps {

/**
 * A window of an X display that shows a picture as large as possible, with its shape kept. One thread.
 * If the X server goes, Xlib ends the process with a line on stderr and status 1.
 */
class X11Window {
 public:
  /** @throw Exception without a display (DISPLAY) of at least 24 bits per pixel. */
  explicit X11Window(const std::string& title);
  ~X11Window();
  X11Window(const X11Window&) = delete;
  X11Window& operator=(const X11Window&) = delete;

  /** Shows a picture until the next. The first picture sets the size of the window. @param[in] rgb top row first. */
  void show(const std::vector<std::uint8_t>& rgb, int width, int height);

  void setTitle(const std::string& title);

  /** Handles what the user did. @return false once the window was closed. */
  bool handleEvents();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::apps
