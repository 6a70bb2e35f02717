#pragma once

// OpenGL 3.3 core without a screen. Its functions are pointers that the first GlContext of a process loads from OSMesa
// or EGL (gl_library.h): the program links to neither, so that it runs where only one of them is.
#include <GL/glcorearb.h>

// Those that are used here. Another one wants a line.
#define RAVEN2_GL_FUNCTIONS(X)                                   \
  X(glAttachShader, PFNGLATTACHSHADERPROC)                       \
  X(glBindBuffer, PFNGLBINDBUFFERPROC)                           \
  X(glBindFramebuffer, PFNGLBINDFRAMEBUFFERPROC)                 \
  X(glBindRenderbuffer, PFNGLBINDRENDERBUFFERPROC)               \
  X(glBindTexture, PFNGLBINDTEXTUREPROC)                         \
  X(glBindVertexArray, PFNGLBINDVERTEXARRAYPROC)                 \
  X(glBlendColor, PFNGLBLENDCOLORPROC)                           \
  X(glBlendFunc, PFNGLBLENDFUNCPROC)                             \
  X(glBlitFramebuffer, PFNGLBLITFRAMEBUFFERPROC)                 \
  X(glBufferData, PFNGLBUFFERDATAPROC)                           \
  X(glCheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC)   \
  X(glClear, PFNGLCLEARPROC)                                     \
  X(glClearColor, PFNGLCLEARCOLORPROC)                           \
  X(glClientWaitSync, PFNGLCLIENTWAITSYNCPROC)                   \
  X(glColorMask, PFNGLCOLORMASKPROC)                             \
  X(glCompileShader, PFNGLCOMPILESHADERPROC)                     \
  X(glCreateProgram, PFNGLCREATEPROGRAMPROC)                     \
  X(glCreateShader, PFNGLCREATESHADERPROC)                       \
  X(glDeleteBuffers, PFNGLDELETEBUFFERSPROC)                     \
  X(glDeleteFramebuffers, PFNGLDELETEFRAMEBUFFERSPROC)           \
  X(glDeleteProgram, PFNGLDELETEPROGRAMPROC)                     \
  X(glDeleteRenderbuffers, PFNGLDELETERENDERBUFFERSPROC)         \
  X(glDeleteShader, PFNGLDELETESHADERPROC)                       \
  X(glDeleteSync, PFNGLDELETESYNCPROC)                           \
  X(glDeleteTextures, PFNGLDELETETEXTURESPROC)                   \
  X(glDeleteVertexArrays, PFNGLDELETEVERTEXARRAYSPROC)           \
  X(glDepthFunc, PFNGLDEPTHFUNCPROC)                             \
  X(glDepthMask, PFNGLDEPTHMASKPROC)                             \
  X(glDisable, PFNGLDISABLEPROC)                                 \
  X(glDrawArrays, PFNGLDRAWARRAYSPROC)                           \
  X(glDrawBuffer, PFNGLDRAWBUFFERPROC)                           \
  X(glDrawElements, PFNGLDRAWELEMENTSPROC)                       \
  X(glEnable, PFNGLENABLEPROC)                                   \
  X(glEnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC) \
  X(glFenceSync, PFNGLFENCESYNCPROC)                             \
  X(glFramebufferRenderbuffer, PFNGLFRAMEBUFFERRENDERBUFFERPROC) \
  X(glFramebufferTexture2D, PFNGLFRAMEBUFFERTEXTURE2DPROC)       \
  X(glGenBuffers, PFNGLGENBUFFERSPROC)                           \
  X(glGenFramebuffers, PFNGLGENFRAMEBUFFERSPROC)                 \
  X(glGenRenderbuffers, PFNGLGENRENDERBUFFERSPROC)               \
  X(glGenTextures, PFNGLGENTEXTURESPROC)                         \
  X(glGenVertexArrays, PFNGLGENVERTEXARRAYSPROC)                 \
  X(glGetIntegerv, PFNGLGETINTEGERVPROC)                         \
  X(glGetProgramInfoLog, PFNGLGETPROGRAMINFOLOGPROC)             \
  X(glGetProgramiv, PFNGLGETPROGRAMIVPROC)                       \
  X(glGetShaderInfoLog, PFNGLGETSHADERINFOLOGPROC)               \
  X(glGetShaderiv, PFNGLGETSHADERIVPROC)                         \
  X(glGetStringi, PFNGLGETSTRINGIPROC)                           \
  X(glGetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC)           \
  X(glLinkProgram, PFNGLLINKPROGRAMPROC)                         \
  X(glPixelStorei, PFNGLPIXELSTOREIPROC)                         \
  X(glPolygonOffset, PFNGLPOLYGONOFFSETPROC)                     \
  X(glReadBuffer, PFNGLREADBUFFERPROC)                           \
  X(glReadPixels, PFNGLREADPIXELSPROC)                           \
  X(glRenderbufferStorage, PFNGLRENDERBUFFERSTORAGEPROC)         \
  X(glScissor, PFNGLSCISSORPROC)                                 \
  X(glShaderSource, PFNGLSHADERSOURCEPROC)                       \
  X(glStencilFunc, PFNGLSTENCILFUNCPROC)                         \
  X(glStencilOp, PFNGLSTENCILOPPROC)                             \
  X(glTexImage2D, PFNGLTEXIMAGE2DPROC)                           \
  X(glTexParameteri, PFNGLTEXPARAMETERIPROC)                     \
  X(glUniform1f, PFNGLUNIFORM1FPROC)                             \
  X(glUniform1i, PFNGLUNIFORM1IPROC)                             \
  X(glUniform3fv, PFNGLUNIFORM3FVPROC)                           \
  X(glUniform4fv, PFNGLUNIFORM4FVPROC)                           \
  X(glUniformMatrix4fv, PFNGLUNIFORMMATRIX4FVPROC)               \
  X(glUseProgram, PFNGLUSEPROGRAMPROC)                           \
  X(glVertexAttribPointer, PFNGLVERTEXATTRIBPOINTERPROC)         \
  X(glViewport, PFNGLVIEWPORTPROC)

namespace raven2_trainer::render {

#define RAVEN2_DECLARE(name, type) inline type name = nullptr;
RAVEN2_GL_FUNCTIONS(RAVEN2_DECLARE)
#undef RAVEN2_DECLARE

}  // namespace raven2_trainer::render
