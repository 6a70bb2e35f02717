#pragma once

// GLSL 3.30 sources. Lighting is computed in linear light; squaring and square root approximate the sRGB curve, since
// pow() costs llvmpipe several milliseconds a frame.

namespace raven2_trainer::render {

/** Meshes: vertices in M, lighting in W. */
constexpr const char* kMeshVertex = R"(#version 330 core
layout(location = 0) in vec3 p_M;
layout(location = 1) in vec3 n_M;
uniform mat4 clip_from_mesh;
uniform mat4 world_from_mesh;
uniform mat4 shadow_from_mesh;
uniform float shadow_lift;
out vec3 p_W;
out vec3 n_W;
out vec3 p_S;
void main() {
  gl_Position = clip_from_mesh * vec4(p_M, 1.0);
  p_W = (world_from_mesh * vec4(p_M, 1.0)).xyz;
  n_W = mat3(world_from_mesh) * n_M;
  p_S = (shadow_from_mesh * vec4(p_M + shadow_lift * n_M, 1.0)).xyz;
}
)";

/** Hemispheric ambient light, a key light with shadow, a fill light; Blinn-Phong highlights with exponent 32. */
constexpr const char* kMeshFragment = R"(#version 330 core
in vec3 p_W;
in vec3 n_W;
in vec3 p_S;
uniform vec4 colour;
uniform vec3 eye_W;
uniform vec3 key_W;
uniform vec3 fill_W;
uniform sampler2DShadow shadow_map;
out vec4 pixel;

float power32(float x) {
  x *= x;
  x *= x;
  x *= x;
  x *= x;
  return x * x;
}

void main() {
  vec3 n = normalize(n_W);
  vec3 v = normalize(eye_W - p_W);
  float lit = texture(shadow_map, vec3(p_S.xy, min(p_S.z, 1.0)));  // beyond the map's depth all is lit
  float key = max(dot(n, key_W), 0.0) * lit;
  float fill = max(dot(n, fill_W), 0.0);
  float shine = power32(max(dot(n, normalize(key_W + v)), 0.0)) * lit;
  vec3 ambient = mix(vec3(0.17, 0.15, 0.14), vec3(0.40, 0.42, 0.46), 0.5 + 0.5 * n.z);
  vec3 light = ambient + key * vec3(0.92, 0.88, 0.82) + fill * vec3(0.16, 0.18, 0.22);
  vec3 rgb = colour.rgb * colour.rgb * light + vec3(0.22 * shine);
  pixel = vec4(sqrt(min(rgb, vec3(1.0))), colour.a);
}
)";

/** Depth alone, seen from the key light. */
constexpr const char* kShadowVertex = R"(#version 330 core
layout(location = 0) in vec3 p_M;
uniform mat4 clip_from_mesh;
void main() { gl_Position = clip_from_mesh * vec4(p_M, 1.0); }
)";

/** For passes without colours. */
constexpr const char* kNoFragment = R"(#version 330 core
void main() {}
)";

/** One colour, without light: the number of a part. */
constexpr const char* kPartFragment = R"(#version 330 core
uniform vec4 colour;
out vec4 pixel;
void main() { pixel = colour; }
)";

/** Tiles of the picture, in clip space. */
constexpr const char* kTileVertex = R"(#version 330 core
layout(location = 0) in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }
)";

/** One triangle over the whole picture, at the far plane. */
constexpr const char* kScreenVertex = R"(#version 330 core
out vec2 at;
void main() {
  at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * at - 1.0, 1.0, 1.0);
}
)";

/** Light grey, lighter at the top. */
constexpr const char* kBackgroundFragment = R"(#version 330 core
in vec2 at;
uniform vec3 top;
uniform vec3 bottom;
out vec4 pixel;
void main() { pixel = vec4(mix(bottom, top, at.y), 1.0); }
)";

}  // namespace raven2_trainer::render
