#pragma once

// Debian's libOSMesa exports every gl* symbol, so no function loader is needed.
#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>

#include <GL/gl.h>
#include <GL/glext.h>
