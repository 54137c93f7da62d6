// Shaders of the map: colour, instance, class and confidence mixed by one slider, soft shading, and ids for picking.
import { FrontSide, GLSL3, ShaderMaterial, Vector3 } from "three";
import type { IdTable } from "./id_table";

const VERTEX = /* glsl */ `
in vec4 tint;
in float instance;
out vec3 vTint;
out float vOpen;
out vec3 vNormal;
out vec3 vWorld;
flat out float vInstance;
void main() {
  vTint = tint.rgb;
  vOpen = tint.a;
  vInstance = instance;
  vNormal = mat3(modelMatrix) * normal;
  vec4 world = modelMatrix * vec4(position, 1.0);
  vWorld = world.xyz;
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const LOOK_UP = /* glsl */ `
precision highp float;
uniform sampler2D table;
uniform int rows;
uniform float ceilingY;
uniform float reveal;
in vec3 vTint;
in float vOpen;
in vec3 vNormal;
in vec3 vWorld;
flat in float vInstance;
vec4 known(int layer) {
  int id = int(vInstance + 0.5);
  return texelFetch(table, ivec2(id & 255, (id >> 8) + layer * rows), 0);
}
void hideWhatIsHidden(vec4 shown) {
  if (reveal < 0.5 && (shown.r < 0.5 || vWorld.y > ceilingY)) discard;
}`;

const FRAGMENT = /* glsl */ `
${LOOK_UP}
uniform float mode;
uniform float asked;
uniform vec3 hitColor;
uniform vec3 fadeColor;
out vec4 color;
void main() {
  vec4 shown = known(3);
  hideWhatIsHidden(shown);
  vec3 n = normalize(vNormal);
  vec3 toEye = normalize(cameraPosition - vWorld);
  float brightness = dot(vTint, vec3(0.3, 0.59, 0.11));
  float painted = clamp(mode, 0.0, 1.0);
  vec3 flatColor = mix(known(0).rgb, known(1).rgb, clamp(mode - 1.0, 0.0, 1.0));
  flatColor = mix(flatColor, known(2).rgb, clamp(mode - 2.0, 0.0, 1.0));
  vec3 base = mix(vTint, flatColor * (0.86 + 0.2 * brightness), painted);
  float sky = 0.5 + 0.5 * n.y;
  float facing = max(dot(n, toEye), 0.0);
  float light = mix(0.9 + 0.07 * sky + 0.06 * facing, 0.66 + 0.2 * sky + 0.2 * facing, painted);
  float open = mix(1.0, vOpen * vOpen * (1.6 - 0.6 * vOpen), 0.75);
  vec3 lit = base * light * open;
  vec3 grey = mix(vec3(dot(lit, vec3(0.3, 0.59, 0.11))), fadeColor, 0.55);
  vec3 hit = mix(lit, hitColor * (0.55 + 0.5 * light * open), 0.35 + 0.5 * shown.g);
  lit = mix(lit, shown.g > 0.0 ? hit : grey, asked);
  color = vec4(lit + 0.07 * shown.b, 1.0);
}`;

const PICK = /* glsl */ `
${LOOK_UP}
out vec4 picked;
void main() {
  hideWhatIsHidden(known(3));
  picked = vec4(vInstance + 1.0, vWorld);
}`;

const MASK_VERTEX = /* glsl */ `
out vec3 vWorld;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  vWorld = world.xyz;
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const MASK = /* glsl */ `
precision highp float;
uniform float ceilingY;
uniform vec3 channel;
in vec3 vWorld;
out vec4 mask;
void main() {
  if (vWorld.y > ceilingY) discard;
  mask = vec4(channel, 1.0);
}`;

export const NO_CEILING = 1e9;

export function mapUniforms(table: IdTable) {
  return {
    table: { value: table.texture },
    rows: { value: table.rows },
    ceilingY: { value: NO_CEILING },
    reveal: { value: 0 }, // 1: shows what is hidden, too
    mode: { value: 0 },
    asked: { value: 0 },
    hitColor: { value: new Vector3(0.94, 0.56, 0.16) },
    fadeColor: { value: new Vector3(0.8, 0.8, 0.8) },
  };
}

export type MapUniforms = ReturnType<typeof mapUniforms>;

function material(vertexShader: string, fragmentShader: string, uniforms: object): ShaderMaterial {
  const shaders = { vertexShader, fragmentShader, uniforms: uniforms as ShaderMaterial["uniforms"] };
  return new ShaderMaterial({ ...shaders, glslVersion: GLSL3, side: FrontSide });
}

export const mapMaterial = (uniforms: MapUniforms): ShaderMaterial => material(VERTEX, FRAGMENT, uniforms);

export const pickMaterial = (uniforms: MapUniforms): ShaderMaterial => material(VERTEX, PICK, uniforms);

/** Fills one colour channel of the mask that outlines are drawn around. */
export function maskMaterial(uniforms: MapUniforms, channel: [number, number, number]): ShaderMaterial {
  const own = { ceilingY: uniforms.ceilingY, channel: { value: new Vector3(...channel) } };
  const result = material(MASK_VERTEX, MASK, own);
  result.depthTest = result.depthWrite = false;
  return result;
}
