// Pictures of instances: crops of the recording where there are any, else drawn from the map when they come in sight.
export interface Drawer {
  draw(id: number): Promise<Blob | null>;
}

export class Pictures {
  private cropBlobs = new Map<number, Blob[]>();
  private addresses = new Map<string, string>();
  private drawn = new Map<number, Promise<Blob | null>>();
  private watched = new WeakMap<Element, number>();
  private readonly watcher: IntersectionObserver;
  remote: ((id: number, n: number) => string) | null = null;
  remoteCounts = new Map<number, number>();

  constructor(private readonly drawer: Drawer) {
    this.watcher = new IntersectionObserver((entries) => {
      for (const { isIntersecting, target } of entries) if (isIntersecting) void this.fill(target as HTMLElement);
    });
  }

  /** Takes the pictures of a map that was loaded anew. */
  replace(crops: Map<number, Blob[]>): void {
    for (const address of this.addresses.values()) URL.revokeObjectURL(address);
    this.addresses.clear();
    this.drawn.clear();
    this.cropBlobs = crops;
  }

  /** Addresses of the crops of an instance, the best first. */
  crops(id: number): string[] {
    const files = this.cropBlobs.get(id) ?? [];
    if (!files.length && this.remote) {
      return Array.from({ length: this.remoteCounts.get(id) ?? 0 }, (_, n) => this.remote!(id, n));
    }
    return files.map((blob, n) => this.address(`${id}/${n}`, blob));
  }

  /** Fills an element with a picture once it is in sight. */
  into(holder: HTMLElement, id: number): void {
    this.watched.set(holder, id);
    this.watcher.observe(holder);
  }

  private async fill(holder: HTMLElement): Promise<void> {
    this.watcher.unobserve(holder);
    const id = this.watched.get(holder)!;
    const address = this.crops(id)[0] ?? (await this.drawing(id));
    if (!address) return;
    const image = new Image();
    image.alt = "";
    image.src = address;
    holder.replaceChildren(image);
  }

  private async drawing(id: number): Promise<string | null> {
    if (!this.drawn.has(id)) this.drawn.set(id, this.drawer.draw(id));
    const blob = await this.drawn.get(id)!;
    return blob && this.address(`${id}/drawn`, blob);
  }

  private address(key: string, blob: Blob): string {
    if (!this.addresses.has(key)) this.addresses.set(key, URL.createObjectURL(blob));
    return this.addresses.get(key)!;
  }
}
