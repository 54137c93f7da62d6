// Edits by hand on a served map: what the card offers, and the tools that need the map itself.
import { Vector3 } from "three";
import type { App } from "../app";
import type { Instance } from "../map_types";
import type { Picked } from "../scene/picker";
import type { Edit, LiveServer, Region } from "../sources/source";
import { Refused } from "../sources/served";
import type { Tool } from "../state/store";
import { lassoOf } from "../scene/lasso";
import { byId, iconButton, make } from "./elements";
import { say } from "./toast";

type Target = (region: Region) => Edit;

export class EditTools {
  private readonly server: LiveServer | null;
  private onPicked: ((id: number) => void) | null = null;
  private stopLasso: (() => void) | null = null;
  private cutting: Target | null = null;
  private corners: Vector3[] = [];

  constructor(private readonly app: App) {
    this.server = app.source.server;
    if (!this.server) return;
    const undo = iconButton("undo", "Undo the last edit", () => void this.step("undo", "Undone"));
    const redo = iconButton("redo", "Redo", () => void this.step("redo", "Done again"));
    const holder = make("div", { id: "history", role: "group", "aria-label": "Edits" }, undo, redo);
    byId("stage").append(holder);
    undo.disabled = redo.disabled = true;
  }

  /** What the card of an instance offers. */
  forInstance(instance: Instance): HTMLElement | null {
    if (!this.server || instance.part_of !== null) return null;
    const { id } = instance;
    const button = (label: string, onclick: () => void): HTMLElement =>
      make("button", { type: "button", className: "plain", onclick }, label);
    return make("details", { className: "editing" }, make("summary", {}, "Edit"),
      this.nameForm(instance),
      make("div", { className: "actions" },
        button("Merge with …", () => this.merge(id)),
        button("Split by lasso", () => this.cut("lasso", (region) => ({ kind: "split", instance: id, region }))),
        button("Split by plane", () => this.cut("plane", (region) => ({ kind: "split", instance: id, region }))),
        button("Give an area to …", () => this.moveBorder(id)),
        button("Delete", () => void this.send({ kind: "delete", instance: id }, "Deleted"))));
  }

  /** A choice in a list while a tool waits for a thing; whether it did. */
  chosen(id: number): boolean {
    if (this.app.store.state.tool !== "pick" || !this.onPicked) return false;
    this.onPicked(id);
    return true;
  }

  /** A click on the map while a tool waits for one. */
  picked(picked: Picked | null): void {
    if (this.app.store.state.tool === "plane") return void (picked && this.planePoint(picked.point));
    if (picked?.id && this.app.model.byId.has(picked.id)) this.onPicked?.(picked.id);
    else say("Click a thing of the map, or press Escape");
  }

  toolChanged(tool: Tool): void {
    if (tool !== "lasso") this.stopLasso?.();
    if (tool !== "pick") this.onPicked = null;
    if (tool !== "plane") this.corners = [];
  }

  /** Says which of undo and redo there is. */
  async refresh(): Promise<void> {
    const [undo, redo] = byId("history").querySelectorAll("button");
    try {
      const state = await this.server!.editState();
      undo.disabled = !state.can_undo;
      redo.disabled = !state.can_redo;
    } catch {
      undo.disabled = redo.disabled = true; // a server that takes no edits
    }
  }

  private nameForm(instance: Instance): HTMLElement {
    const known = this.app.model.names;
    const listId = "known-names";
    const field = make("input", { value: instance.name, maxLength: 100, "aria-label": "Name or class", autocomplete: "off" });
    field.setAttribute("list", listId);
    const form = make("form", { className: "naming" }, field,
      make("datalist", { id: listId }, ...known.map((name) => make("option", { value: name }))),
      make("button", { type: "submit", className: "plain" }, "Rename"),
      make("button", { type: "button", className: "plain", onclick: () => {
        void this.send({ kind: "relabel", instance: instance.id, class: field.value.trim() }, "Its class is changed");
      } }, "Set class"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.send({ kind: "rename", instance: instance.id, name: field.value.trim() }, "Renamed");
    });
    return form;
  }

  private merge(id: number): void {
    say(`Choose what belongs to ${this.app.model.label(id)}, on the map or in the list`, 60);
    this.app.store.set({ tool: "pick" });
    this.onPicked = (other) => {
      if (other === id) return say("That is the thing itself: choose another one");
      this.app.store.set({ tool: "none" });
      void this.send({ kind: "merge", instances: [id, other] }, "Merged");
    };
  }

  private moveBorder(id: number): void {
    say(`Choose the neighbour that gets an area of ${this.app.model.label(id)}`, 60);
    this.app.store.set({ tool: "pick" });
    this.onPicked = (other) => {
      if (other !== id) this.cut("lasso", (region) => ({ kind: "move_border", from: id, to: other, region }));
    };
  }

  private cut(tool: "lasso" | "plane", target: Target): void {
    this.cutting = target;
    this.app.store.set({ tool });
    if (tool === "plane") return say("Click three points of the cut: your side of it is split off", 60);
    say("Draw around what is split off", 60);
    this.stopLasso = lassoOf(this.app.viewport, (region) => {
      this.stopLasso = null;
      this.app.store.set({ tool: "none" });
      if (region) void this.send(target(region), "Done");
    });
  }

  private planePoint(point: Vector3): void {
    this.corners.push(point);
    if (this.corners.length < 3) return say(`${3 - this.corners.length} more`, 60);
    const { viewport } = this.app;
    const [a, b, c] = this.corners.map((corner) => viewport.toMap(corner));
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    if (normal.length() < 1e-4) return say("These points lie on a line: click others");
    normal.normalize();
    if (normal.dot(viewport.toMap(viewport.camera.position).sub(a)) < 0) normal.negate();
    const region: Region = { plane: { normal: normal.toArray(), offset_m: normal.dot(a) } };
    this.app.store.set({ tool: "none" });
    if (this.cutting) void this.send(this.cutting(region), "Split");
  }

  private send(edit: Edit, done: string): Promise<void> {
    return this.run((server) => server.edit(edit, this.app.model.header.epoch), done);
  }

  private step(which: "undo" | "redo", done: string): Promise<void> {
    return this.run((server) => server[which](this.app.model.header.epoch), done);
  }

  private async run(act: (server: LiveServer) => Promise<void>, done: string): Promise<void> {
    try {
      await act(this.server!);
      await this.app.reload();
      say(done);
    } catch (error) {
      say((error as Error).message, 9);
      if (error instanceof Refused && error.status === 409) await this.app.reload();
    }
  }
}
