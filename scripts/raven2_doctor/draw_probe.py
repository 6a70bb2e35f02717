"""Draws one picture with OSMesa and looks at it. Run by software.opengl in a process of its own."""

import ctypes
import sys

OSMESA_RGBA, GL_UNSIGNED_BYTE, GL_COLOR_BUFFER_BIT, GL_RENDERER = 0x1908, 0x1401, 0x4000, 0x1F01
SIZE = 16  # [px]
COLOUR = (255, 102, 0, 255)


def main():
    library = ctypes.CDLL("libOSMesa.so.8")
    library.OSMesaCreateContextExt.restype = ctypes.c_void_p
    library.OSMesaMakeCurrent.argtypes = [ctypes.c_void_p, ctypes.c_void_p] + 3 * [ctypes.c_int]
    library.glClearColor.argtypes = 4 * [ctypes.c_float]
    library.glGetString.restype = ctypes.c_char_p
    context = library.OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, None)
    if not context:
        sys.exit("no context")
    pixels = (ctypes.c_ubyte * (4 * SIZE * SIZE))()
    if not library.OSMesaMakeCurrent(context, pixels, GL_UNSIGNED_BYTE, SIZE, SIZE):
        sys.exit("the context cannot be used")
    library.glClearColor(*(value / 255 for value in COLOUR))
    library.glClear(GL_COLOR_BUFFER_BIT)
    library.glFinish()
    if bytes(pixels) != bytes(COLOUR) * SIZE * SIZE:
        sys.exit(f"the picture is wrong: {tuple(pixels[:4])} instead of {COLOUR}")
    print((library.glGetString(GL_RENDERER) or b"unknown").decode())


main()
