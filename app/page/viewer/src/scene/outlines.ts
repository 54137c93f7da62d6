// Outlines around what is pointed at, chosen or found, through whatever stands before it: the instances' shapes are
// drawn into a mask, and its borders over the picture.
import {
  BufferAttribute,
  BufferGeometry,
  Camera,
  GLSL3,
  Group,
  Mesh,
  Scene,
  ShaderMaterial,
  Vector2,
  Vector3,
  WebGLRenderTarget,
} from "three";
import { maskMaterial } from "./map_material";
import type { Viewport } from "./viewport";

const VERTEX = /* glsl */ `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;

const FRAGMENT = /* glsl */ `
precision highp float;
uniform sampler2D mask;
uniform vec2 step_px;
uniform vec3 colors[3];
out vec4 color;
void main() {
  vec2 size = vec2(textureSize(mask, 0));
  vec2 at = gl_FragCoord.xy / size;
  vec3 inside = texture(mask, at).rgb;
  vec3 near = vec3(0.0);
  for (int i = 0; i < 16; i++) {
    float angle = 6.2831853 * float(i) / 16.0;
    float reach = (i & 1) == 0 ? 1.0 : 0.55;
    near += texture(mask, at + reach * step_px * vec2(cos(angle), sin(angle)) / size).rgb;
  }
  vec3 border = clamp(near / 5.0, 0.0, 1.0) * (1.0 - inside);
  float strength = max(border.r, max(border.g, border.b));
  if (strength < 0.02) discard;
  vec3 tint = border.r >= border.g && border.r >= border.b ? colors[0] : border.g >= border.b ? colors[1] : colors[2];
  color = vec4(tint, strength);
}`;

export interface Outlined {
  hovered: number[];
  selected: number[];
  hits: number[];
}

export class Outlines {
  private readonly target = new WebGLRenderTarget(1, 1, { depthBuffer: false });
  private readonly masks = new Scene();
  private readonly holder = new Group();
  private readonly cover = new Scene();
  private readonly camera = new Camera();
  private readonly material: ShaderMaterial;
  private readonly channels;
  private outlined: Outlined = { hovered: [], selected: [], hits: [] };

  constructor(private readonly viewport: Viewport) {
    const { uniforms } = viewport;
    this.channels = {
      hovered: maskMaterial(uniforms, [1, 0, 0]),
      selected: maskMaterial(uniforms, [0, 1, 0]),
      hits: maskMaterial(uniforms, [0, 0, 1]),
    };
    const colors = [new Vector3(1, 1, 1), new Vector3(0.15, 0.5, 0.95), new Vector3(0.93, 0.52, 0.1)];
    const own = { mask: { value: this.target.texture }, step_px: { value: new Vector2() }, colors: { value: colors } };
    this.material = new ShaderMaterial({
      vertexShader: VERTEX.replace("in vec3 position;", ""),
      fragmentShader: FRAGMENT,
      uniforms: own,
      glslVersion: GLSL3,
      transparent: true,
      depthTest: false,
      depthWrite: false,
    });
    const triangle = new BufferGeometry();
    triangle.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const sheet = new Mesh(triangle, this.material);
    sheet.frustumCulled = false;
    this.cover.add(sheet);
    this.masks.add(this.holder);
    viewport.onFrame(() => this.render());
  }

  setHoverColor(rgb: [number, number, number]): void {
    (this.material.uniforms.colors.value as Vector3[])[0].set(...rgb);
  }

  show(outlined: Outlined): void {
    this.outlined = outlined;
    this.holder.clear();
    this.holder.quaternion.copy(this.viewport.root.quaternion);
    for (const name of ["hits", "selected", "hovered"] as const) {
      for (const id of outlined[name]) {
        const parts = this.viewport.surfaces.partsOf(id, this.channels[name]);
        if (parts.length) this.holder.add(...parts);
      }
    }
    this.viewport.draw();
  }

  /** The same again, of surfaces that have changed. */
  refresh(): void {
    this.show(this.outlined);
  }

  private render(): void {
    if (!this.holder.children.length) return;
    const { renderer, camera } = this.viewport;
    const size = renderer.getDrawingBufferSize(new Vector2());
    if (this.target.width !== size.x || this.target.height !== size.y) this.target.setSize(size.x, size.y);
    const width = 2.2 * renderer.getPixelRatio();
    (this.material.uniforms.step_px.value as Vector2).set(width, width);
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(this.masks, camera);
    renderer.setRenderTarget(null);
    renderer.render(this.cover, this.camera);
  }
}
