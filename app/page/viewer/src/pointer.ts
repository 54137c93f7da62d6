// Pointing at the map and clicking on it.
import type { App } from "./app";
import { byId } from "./panels/elements";

const STILL_PX = 5; // a press that moved farther was a drag

export function listenToPointer(app: App): void {
  const { canvas } = app.viewport;
  const label = byId("hover-label");
  let pressed: { x: number; y: number } | null = null;
  let pending: { x: number; y: number } | null = null;
  let busy = false;

  const place = (event: PointerEvent): { x: number; y: number } => {
    const bounds = canvas.getBoundingClientRect();
    return { x: event.clientX - bounds.left, y: event.clientY - bounds.top };
  };
  const point = async (): Promise<void> => {
    if (busy || !pending || !app.model) return;
    busy = true;
    const at = pending;
    pending = null;
    const picked = await app.picker.at(at.x, at.y);
    const id = picked && app.model.byId.has(picked.id) ? picked.id : null;
    app.store.set({ hovered: id });
    label.hidden = id === null;
    if (id !== null) {
      label.textContent = app.model.label(id);
      label.style.left = `${at.x}px`;
      label.style.top = `${at.y}px`;
    }
    busy = false;
    setTimeout(point, 30);
  };
  canvas.addEventListener("pointerdown", (event) => {
    pressed = event.button === 0 && event.isPrimary ? place(event) : null;
    label.hidden = true;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons || event.pointerType === "touch") return;
    pending = place(event);
    void point();
  });
  canvas.addEventListener("pointerleave", () => {
    pending = null;
    label.hidden = true;
    app.store.set({ hovered: null });
  });
  canvas.addEventListener("pointerup", (event) => {
    const at = place(event);
    const isClick = pressed && Math.hypot(at.x - pressed.x, at.y - pressed.y) < STILL_PX;
    pressed = null;
    if (isClick && app.model) void app.picker.at(at.x, at.y).then((picked) => app.clicked(picked));
  });
}
