// The page: brings scene, panels and source together.
import { Decoder } from "./decoding/decoder";
import type { LoadedMap } from "./map_types";
import { Card } from "./panels/card";
import { byId } from "./panels/elements";
import { Filters, passing } from "./panels/filters";
import { ListPanel } from "./panels/list";
import { Search } from "./panels/search";
import { say } from "./panels/toast";
import { showHelp, Toolbar } from "./panels/toolbar";
import { CameraTrack } from "./scene/camera_track";
import { BoxMark, distanceText, Ruler } from "./scene/marks";
import { Navigation } from "./scene/navigation";
import { Outlines } from "./scene/outlines";
import { Picker, type Picked } from "./scene/picker";
import { measure } from "./scene/space";
import { Thumbnails } from "./scene/thumbnails";
import { Viewport } from "./scene/viewport";
import { warmUp, type Marked } from "./scene/warm_up";
import type { MapSource } from "./sources/source";
import { EditTools } from "./panels/edit_tools";
import { Growth } from "./sources/growth";
import { fromHash, keepInAddress, toHash } from "./state/hash";
import { MapModel } from "./state/map_model";
import { paintTable } from "./scene/paint_table";
import { Pictures } from "./state/pictures";
import { initialState, Store, type State } from "./state/store";
import { savePicture } from "./scene/picture_file";
import { listenToPointer } from "./pointer";
import { listenToKeys } from "./keyboard";

const GIVEN_COLOR = 0x2f7de1;
const ESTIMATED_COLOR = 0xe0812b;

export class App {
  readonly store: Store;
  readonly viewport = new Viewport(byId<HTMLCanvasElement>("view"));
  readonly navigation = new Navigation(this.viewport);
  readonly picker = new Picker(this.viewport);
  readonly decoder = new Decoder();
  readonly search: Search;
  readonly track = new CameraTrack(this.viewport, this.navigation);
  readonly toolbar: Toolbar;
  readonly ruler = new Ruler(this.viewport, byId("ruler-label"));
  readonly editing: EditTools;
  model!: MapModel;
  private readonly outlines = new Outlines(this.viewport);
  private readonly thumbnails = new Thumbnails(this.viewport, (id) => this.model.byId.get(id));
  private readonly pictures = new Pictures(this.thumbnails);
  private readonly box = new BoxMark(this.viewport);
  private readonly list: ListPanel;
  private readonly filters: Filters;
  private readonly card: Card;
  private hashTimer = 0;
  private isEmpty = false;

  constructor(readonly source: MapSource) {
    const linked = fromHash(location.hash);
    this.store = new Store({ ...initialState(), ...linked.state, selected: null, isolated: null, walking: false });
    this.toolbar = new Toolbar(this.store);
    this.list = new ListPanel(this.store, this.pictures, (id) => this.chooseListed(id));
    this.filters = new Filters(this.store);
    this.search = new Search(this.store, () => this.model, source.server, (ids) => this.flyToAll(ids));
    this.editing = new EditTools(this);
    this.card = new Card(this.pictures, {
      choose: (id) => this.choose(id),
      fly: (id) => this.fly(id),
      isolate: (id) => this.isolate(id),
      close: () => this.store.set({ selected: null }),
      editTools: (instance) => this.editing.forInstance(instance),
    });
    if (source.server) this.pictures.remote = source.server.cropAddress;
    this.store.subscribe((state, changed) => this.changed(state, changed));
    this.navigation.onMoved = () => this.remember();
    listenToPointer(this);
    listenToKeys(this, showHelp);
    this.applyTheme();
  }

  async start(): Promise<void> {
    const linked = fromHash(location.hash);
    const loaded = await this.source.load(this.decoder);
    this.take(loaded);
    const { state } = linked;
    if (linked.view) this.navigation.set(linked.view);
    else this.navigation.set(this.navigation.home());
    await warmUp(this.marked, this.model.instances[0]);
    if (state.walking) {
      this.navigation.walk(true, linked.view);
      this.store.set({ walking: true });
    }
    if (state.search) this.search.restore(state.search);
    if (state.isolated && this.model.byId.has(state.isolated)) this.store.set({ isolated: state.isolated });
    if (state.selected && this.model.byId.has(state.selected)) this.store.set({ selected: state.selected });
    if (this.source.server) new Growth(this, this.source.server);
    byId("loading").remove();
    document.body.dataset.ready = "1";
  }

  private get marked(): Marked {
    const { viewport, outlines, box, ruler, picker, thumbnails } = this;
    return { viewport, outlines, box, ruler, picker, thumbnails };
  }

  /** Shows a map, the first one or one that was changed. */
  take(loaded: LoadedMap): void {
    const isFirst = !this.model;
    this.model = new MapModel(loaded);
    const { header } = loaded;
    const turn = this.viewport.setUp(header.up);
    if (!isFirst) this.navigation.turnWith(turn);
    const hasMesh = Boolean(header.mesh?.triangles);
    this.isEmpty ||= !hasMesh;
    if (hasMesh) this.viewport.surfaces.set("map", loaded.surface);
    this.viewport.surfaces.set("other", loaded.other);
    this.pictures.replace(loaded.crops);
    for (const { id, crops } of header.instances) this.pictures.remoteCounts.set(id, crops);
    this.measure();
    this.toolbar.build({
      home: () => this.home(),
      picture: () => savePicture(this.viewport, header.title),
      play: () => this.togglePlay(),
      seek: (share) => { this.track.pause(); this.track.seek(share); },
      compare: header.other ? () => {} : null,
      hasPath: (header.camera_path?.positions_m.length ?? 0) > 1,
      hasCeiling: this.viewport.ceilingY < 1e8,
      help: showHelp,
    });
    this.track.onTime = (share) => this.toolbar.played(share, this.track.isPlaying);
    byId("title").textContent = header.title;
    byId("notes").textContent = header.notes.join(" ");
    const { selected, isolated } = this.store.state;
    if (selected !== null && !this.model.byId.has(selected)) this.store.set({ selected: null });
    if (isolated !== null && !this.model.byId.has(isolated)) this.store.set({ isolated: null });
    this.changed(this.store.state, new Set(Object.keys(this.store.state) as (keyof State)[]));
  }

  measure(): void {
    const space = measure(this.viewport, this.model.instances);
    this.navigation.setSpace(space);
    this.viewport.ceilingY = space.ceilingY;
    this.thumbnails.middle = space.center.toArray();
  }

  choose(id: number): void {
    if (this.editing.chosen(id)) return;
    this.store.set({ selected: id });
    this.fly(id);
  }

  /** Chosen in the list, which covers the map on a phone. */
  private chooseListed(id: number): void {
    document.body.classList.remove("list-open");
    this.choose(id);
  }

  fly(id: number): void {
    const instance = this.model.byId.get(id);
    if (!instance) return;
    this.store.set({ walking: false, playing: false });
    this.navigation.fly(this.navigation.viewOf(instance));
  }

  isolate(id: number): void {
    this.store.set({ isolated: this.store.state.isolated === id ? null : id });
  }

  home(): void {
    this.store.set({ walking: false, playing: false });
    this.navigation.fly(this.navigation.home());
  }

  togglePlay(): void {
    if (!this.store.state.playing) {
      this.store.set({ playing: true, walking: false });
      this.track.play();
    } else if (this.track.isPlaying) this.track.pause();
    else this.track.play();
    this.track.setLineVisible(!this.track.isPlaying); // a line through one's own eyes says nothing
    this.toolbar.played(null, this.track.isPlaying);
  }

  /** A click on the map. */
  clicked(picked: Picked | null): void {
    const { tool, walking } = this.store.state;
    if (tool === "ruler") {
      const distance_m = picked && this.ruler.add(picked.point);
      if (distance_m) say(`${distanceText(distance_m)} apart`);
    } else if (tool === "pick" || tool === "plane") this.editing.picked(picked);
    else if (walking && picked && (!picked.id || this.model.byId.get(picked.id)?.name === "floor")) {
      this.navigation.stepTo(picked.point);
    } else if (picked?.id && this.model.byId.has(picked.id)) {
      if (walking) this.store.set({ selected: picked.id });
      else this.choose(picked.id);
    } else this.store.set({ selected: null });
  }

  /** What was under the pointer is there no more: the view has moved. */
  private unpoint(): void {
    byId("hover-label").hidden = true;
    this.store.set({ hovered: null });
  }

  private flyToAll(ids: number[]): void {
    const shown = ids.filter((id) => this.model.byId.has(id));
    if (shown.length === 1) this.fly(shown[0]);
    else if (shown.length) this.navigation.fly(this.navigation.home());
  }

  private changed(state: State, changed: Set<keyof State>): void {
    const any = (...keys: (keyof State)[]): boolean => keys.some((key) => changed.has(key));
    if (any("theme")) this.applyTheme();
    if (!this.model) return;
    if (any("mode", "hits")) {
      this.viewport.uniforms.mode.value = state.mode;
      this.viewport.uniforms.asked.value = state.hits ? 1 : 0;
      this.viewport.draw();
    }
    if (any("hits", "isolated", "minScore", "minSize_cm", "hovered")) this.paint(state);
    if (any("hits", "minScore", "minSize_cm")) this.fillList();
    else if (any("selected", "hovered")) this.list.mark();
    if (any("selected", "isolated")) this.showCard(state);
    if (any("selected", "hovered", "hits", "isolated")) this.outline(state);
    if (any("walking")) this.navigation.walk(state.walking);
    if (any("walking", "playing") && state.hovered !== null) this.unpoint();
    if (any("hidesCeiling")) this.viewport.hidesCeiling = state.hidesCeiling;
    if (any("playing", "showsOther")) this.showPaths(state);
    if (any("tool")) this.useTool(state);
    this.toolbar.mark();
    this.filters.mark();
    this.viewport.draw();
    this.remember();
  }

  private fillList(): void {
    const { minScore, minSize_cm, hits } = this.store.state;
    const shown = passing(this.model, minScore, minSize_cm);
    this.list.show(this.model, hits ? new Set([...shown].filter((id) => hits.has(id))) : shown);
  }

  private paint(state: State): void {
    const shown = passing(this.model, state.minScore, state.minSize_cm);
    paintTable(this.viewport.table, this.model, state, shown);
    this.viewport.refreshTable();
  }

  private outline({ selected, hovered, hits }: State): void {
    const found = hits && hits.size <= 60 ? [...hits.keys()] : [];
    const chosen = selected === null ? [] : [selected];
    const pointed = hovered === null || hovered === selected ? [] : [hovered];
    this.outlines.show({ hovered: pointed, selected: chosen, hits: found.filter((id) => id !== selected) });
  }

  /** The map anew from its server, seen from the same place. */
  async reload(): Promise<void> {
    const loaded = await this.source.load(this.decoder);
    if (loaded.header.mesh?.triangles) this.viewport.surfaces.clear();
    this.take(loaded);
    await this.editing.refresh();
  }

  /** Blocks of the map have changed. */
  grown(): void {
    const wasEmpty = this.isEmpty;
    this.measure();
    this.outlines.refresh();
    if (wasEmpty) this.navigation.set(this.navigation.home());
    this.isEmpty = false;
    this.viewport.draw();
  }

  private showCard({ selected, isolated }: State): void {
    const instance = selected === null ? undefined : this.model.byId.get(selected);
    document.body.classList.toggle("card-open", Boolean(instance));
    this.box.show(instance ?? null);
    if (!instance) return this.card.hide();
    this.card.show(this.model, instance, isolated === instance.id);
    this.list.mark();
    this.list.reveal(instance.id);
  }

  private showPaths({ playing, showsOther }: State): void {
    const { header } = this.model;
    const other = showsOther ? header.other : null;
    this.viewport.surfaces.setVisible("map", !other);
    this.viewport.surfaces.setVisible("other", Boolean(other));
    this.track.show(other ? other.camera_path : header.camera_path, other ? ESTIMATED_COLOR : GIVEN_COLOR);
    this.track.setLineVisible(Boolean(header.other) && !playing);
    if (header.other) {
      byId("title").textContent = `${header.title}, ${other ? "estimated" : "given"} poses`;
      say(other ? "Mapped with estimated poses" : "Mapped with given poses", 3);
    }
    if (!playing) this.track.pause();
  }

  private useTool({ tool }: State): void {
    document.body.dataset.tool = tool;
    if (tool !== "ruler") this.ruler.clear();
    else say("Click two points on the map");
    this.editing.toolChanged(tool);
  }

  private applyTheme(): void {
    const { theme } = this.store.state;
    document.documentElement.dataset.theme = theme;
    this.outlines.setHoverColor(theme === "dark" ? [1, 1, 1] : [0.13, 0.14, 0.17]);
    this.viewport.uniforms.fadeColor.value.setScalar(theme === "dark" ? 0.2 : 0.86);
    this.viewport.draw();
  }

  private remember(): void {
    clearTimeout(this.hashTimer);
    this.hashTimer = window.setTimeout(() => keepInAddress(toHash(this.store.state, this.navigation.view)), 300);
  }
}
