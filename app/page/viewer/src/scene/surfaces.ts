// The surfaces that are shown: that of the map or of its blocks, and that of the map with other poses.
import { BufferAttribute, BufferGeometry, Group, Mesh, type Material } from "three";
import type { SurfaceArrays } from "../map_types";

interface Shown {
  mesh: Mesh;
  ranges: Map<number, [number, number]>;
  parts: Map<number, BufferGeometry>; // of single instances; they own nothing, so that they are not disposed of
}

export class Surfaces {
  readonly group = new Group();
  private readonly shown = new Map<string, Shown>();

  constructor(private readonly material: Material) {}

  /** Shows a surface under a name, in place of an older one; null takes it away. */
  set(name: string, surface: SurfaceArrays | null): void {
    const old = this.shown.get(name);
    if (old) {
      this.group.remove(old.mesh);
      old.mesh.geometry.dispose();
      this.shown.delete(name);
    }
    if (!surface || !surface.triangles.length) return;
    const mesh = new Mesh(geometryOf(surface), this.material);
    const ranges = new Map(surface.ranges.map(([id, start, count]) => [id, [start, count]]));
    this.shown.set(name, { mesh, ranges: ranges as Map<number, [number, number]>, parts: new Map() });
    this.group.add(mesh);
  }

  clear(): void {
    for (const name of [...this.shown.keys()]) this.set(name, null);
  }

  setVisible(name: string, visible: boolean): void {
    const shown = this.shown.get(name);
    if (shown) shown.mesh.visible = visible;
  }

  /** Meshes of one instance alone, which share the arrays of the whole. */
  partsOf(id: number, material: Material): Mesh[] {
    const parts: Mesh[] = [];
    for (const shown of this.shown.values()) {
      if (!shown.ranges.has(id) || !shown.mesh.visible) continue;
      const part = new Mesh(partGeometry(shown, id), material);
      part.frustumCulled = false;
      parts.push(part);
    }
    return parts;
  }

  /** Every n-th vertex of what is shown, at most so many: positions and normals in the map's own frame. */
  sample(most: number): { position: [number, number, number]; normal: [number, number, number] }[] {
    const result = [];
    const total = [...this.shown.values()].reduce((sum, { mesh }) => sum + mesh.geometry.attributes.position.count, 0);
    const step = Math.max(1, Math.ceil(total / most));
    for (const { mesh } of this.shown.values()) {
      const { position, normal } = mesh.geometry.attributes;
      for (let i = 0; i < position.count; i += step) {
        const at = [position.getX(i), position.getY(i), position.getZ(i)] as [number, number, number];
        result.push({ position: at, normal: [normal.getX(i), normal.getY(i), normal.getZ(i)] as typeof at });
      }
    }
    return result;
  }
}

function partGeometry({ mesh, ranges, parts }: Shown, id: number): BufferGeometry {
  let geometry = parts.get(id);
  if (!geometry) {
    geometry = new BufferGeometry();
    geometry.setIndex(mesh.geometry.index);
    for (const [name, attribute] of Object.entries(mesh.geometry.attributes)) geometry.setAttribute(name, attribute);
    geometry.setDrawRange(...ranges.get(id)!);
    geometry.boundingSphere = mesh.geometry.boundingSphere; // measuring it anew would look at all vertices
    parts.set(id, geometry);
  }
  return geometry;
}

function geometryOf(surface: SurfaceArrays): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(surface.positions, 3));
  const normals = new BufferAttribute(surface.normals, 4, true);
  geometry.setAttribute("normal", normals);
  geometry.setAttribute("tint", new BufferAttribute(surface.colors, 4, true));
  geometry.setAttribute("instance", new BufferAttribute(surface.ids, 1));
  geometry.setIndex(new BufferAttribute(surface.triangles, 1));
  geometry.computeBoundingSphere();
  return geometry;
}
