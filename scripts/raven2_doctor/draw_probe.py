"""Draws one picture as the daemon does, with OSMesa or EGL, and looks at it. software.opengl runs it in a separate process."""

import ctypes
import os
import sys

GL_RGBA, GL_UNSIGNED_BYTE, GL_COLOR_BUFFER_BIT, GL_RENDERER, GL_FRAMEBUFFER = 0x1908, 0x1401, 0x4000, 0x1F01, 0x8D40
GL_RENDERBUFFER, GL_RGBA8, GL_COLOR_ATTACHMENT0 = 0x8D41, 0x8058, 0x8CE0
EGL_SURFACELESS, EGL_OPENGL_API, EGL_NONE = 0x31DD, 0x30A2, 0x3038
SIZE = 16  # [px]
COLOUR = (255, 102, 0, 255)
POINTER = ctypes.c_void_p


def osmesa(library):
    """Makes a context of it current. @return address of a function by its name."""
    library.OSMesaCreateContextExt.restype = library.OSMesaGetProcAddress.restype = POINTER
    library.OSMesaMakeCurrent.argtypes = [POINTER, POINTER] + 3 * [ctypes.c_int]
    context = library.OSMesaCreateContextExt(GL_RGBA, 24, 0, 0, None)
    if not context:
        sys.exit("OSMesa has no context")
    library.pixel = (ctypes.c_ubyte * 4)()
    if not library.OSMesaMakeCurrent(context, library.pixel, GL_UNSIGNED_BYTE, 1, 1):
        sys.exit("OSMesa's context cannot be used")
    return library.OSMesaGetProcAddress


def egl(library):
    library.eglGetPlatformDisplay.restype = library.eglCreateContext.restype = library.eglGetProcAddress.restype = POINTER
    library.eglGetPlatformDisplay.argtypes = [ctypes.c_uint, POINTER, POINTER]
    library.eglInitialize.argtypes, library.eglMakeCurrent.argtypes = [POINTER] * 3, [POINTER] * 4
    library.eglCreateContext.argtypes = [POINTER] * 4
    library.eglChooseConfig.argtypes = [POINTER] * 3 + [ctypes.c_int, POINTER]
    display, config, count = library.eglGetPlatformDisplay(EGL_SURFACELESS, None, None), POINTER(), ctypes.c_int()
    if not display or not library.eglInitialize(display, None, None):
        sys.exit("EGL has no surfaceless platform")
    library.eglBindAPI(EGL_OPENGL_API)
    wanted = (ctypes.c_int * 5)(0x3033, 1, 0x3040, 8, EGL_NONE)
    library.eglChooseConfig(display, wanted, ctypes.byref(config), 1, ctypes.byref(count))
    attributes = (ctypes.c_int * 7)(0x3098, 3, 0x30FB, 3, 0x30FD, 1, EGL_NONE)
    context = library.eglCreateContext(display, config, None, attributes) if count.value else None
    if not context or not library.eglMakeCurrent(display, None, None, context):
        sys.exit("EGL has no OpenGL 3.3")
    return library.eglGetProcAddress


LIBRARIES = {"osmesa": (("libOSMesa.so.8", "libOSMesa.so.6"), osmesa), "egl": (("libEGL.so.1",), egl)}


def load():
    """As src/render/gl_library.cpp chooses. @return its name and the address of a function by its name."""
    wanted = os.environ.get("RAVEN2_TRAINER_GL") or "auto"
    for name, (files, begin) in LIBRARIES.items():
        for file in files if wanted in (name, "auto") else ():
            try:
                library = ctypes.CDLL(file)
            except OSError:
                continue
            return name, begin(library)
    sys.exit(f"neither libOSMesa.so.8 nor libEGL.so.1 is there (RAVEN2_TRAINER_GL: {wanted})")


def main():
    name, address = load()

    def gl(function, *arguments, result=None):
        kinds = [ctypes.c_float if isinstance(a, float) else POINTER if not isinstance(a, int) else ctypes.c_uint
                 for a in arguments]
        return ctypes.CFUNCTYPE(result, *kinds)(address(function.encode()))(*arguments)

    target, buffer = ctypes.c_uint(), ctypes.c_uint()
    gl("glGenFramebuffers", 1, ctypes.byref(target))
    gl("glBindFramebuffer", GL_FRAMEBUFFER, target.value)
    gl("glGenRenderbuffers", 1, ctypes.byref(buffer))
    gl("glBindRenderbuffer", GL_RENDERBUFFER, buffer.value)
    gl("glRenderbufferStorage", GL_RENDERBUFFER, GL_RGBA8, SIZE, SIZE)
    gl("glFramebufferRenderbuffer", GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffer.value)
    gl("glClearColor", *(value / 255.0 for value in COLOUR))
    gl("glClear", GL_COLOR_BUFFER_BIT)
    pixels = (ctypes.c_ubyte * (4 * SIZE * SIZE))()
    gl("glReadPixels", 0, 0, SIZE, SIZE, GL_RGBA, GL_UNSIGNED_BYTE, pixels)
    if bytes(pixels) != bytes(COLOUR) * SIZE * SIZE:
        sys.exit(f"the picture is wrong: {tuple(pixels[:4])} instead of {COLOUR}")
    print(f"{name}, {(gl('glGetString', GL_RENDERER, result=ctypes.c_char_p) or b'unknown').decode()}")


main()
