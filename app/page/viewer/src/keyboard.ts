// Keys of the page; none while one types.
import type { App } from "./app";
import { savePicture } from "./scene/picture_file";

export function listenToKeys(app: App, help: () => void): void {
  const { store } = app;
  const selected = (then: (id: number) => void): void => {
    if (store.state.selected !== null) then(store.state.selected);
  };
  const actions: Record<string, () => void> = {
    "/": () => app.search.focus(),
    "?": help,
    "1": () => app.toolbar.glide(0),
    "2": () => app.toolbar.glide(1),
    "3": () => app.toolbar.glide(2),
    "4": () => app.toolbar.glide(3),
    h: () => app.home(),
    f: () => selected((id) => app.fly(id)),
    i: () => selected((id) => app.isolate(id)),
    r: () => store.set({ tool: store.state.tool === "ruler" ? "none" : "ruler" }),
    p: () => app.model.header.camera_path && app.togglePlay(),
    c: () => store.set({ hidesCeiling: !store.state.hidesCeiling }),
    b: () => app.model.header.other && store.set({ showsOther: !store.state.showsOther }),
    t: () => store.set({ theme: store.state.theme === "dark" ? "light" : "dark" }),
    Escape: () => letGo(app),
  };
  window.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || !app.model) return;
    if (document.querySelector("dialog[open]")) return; // its keys are its own
    if (/^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName)) {
      if (event.key === "Escape") target.blur();
      return;
    }
    // Letters that steer one's steps do nothing else meanwhile.
    const steers = /^(Arrow|Key[WASDQE]$|ShiftLeft)/.test(event.code);
    if (store.state.walking ? steers : event.code.startsWith("Arrow") && target.id === "view") {
      app.navigation.key(event.code, true);
      event.preventDefault();
      return;
    }
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (key === "w") store.set({ walking: true });
    else if (key === "s") savePicture(app.viewport, app.model.header.title);
    else if (actions[key]) actions[key]();
    else return;
    event.preventDefault();
  });
  window.addEventListener("keyup", (event) => app.navigation.key(event.code, false));
}

function letGo(app: App): void {
  const { state } = app.store;
  if (state.tool !== "none") app.store.set({ tool: "none" });
  else if (state.walking) app.store.set({ walking: false });
  else if (state.playing) app.store.set({ playing: false });
  else if (state.isolated !== null) app.store.set({ isolated: null });
  else if (state.selected !== null) app.store.set({ selected: null });
  else app.search.clear();
}
