// Making elements of the page.
type Properties = Record<string, unknown>;
type Child = Node | string | null | undefined | false;

/** An element with properties (`onclick`, `textContent` ...); names with a dash become attributes. */
export function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined) continue;
    if (name.includes("-") || name === "role") node.setAttribute(name, String(value));
    else (node as unknown as Properties)[name] = value;
  }
  node.append(...children.filter((child): child is Node | string => Boolean(child)));
  return node;
}

export function byId<Kind extends HTMLElement = HTMLElement>(id: string): Kind {
  return document.getElementById(id) as Kind;
}

const ICONS: Record<string, string> = {
  home: "M4 11 12 4l8 7M6 10v9h12v-9M10 19v-5h4v5",
  walk: "M13 4.5a1 1 0 1 0 0-.01M9 20l2.5-6L9 11.5 12 8l3 3 3 1M11.5 14l3 2.5L15.500 20M9 11.500 7 13",
  ruler: "M3 16 16 3l5 5L8 21zM7 12l2 2M10 9l2 2M13 6l2 2",
  play: "M7 5v14l12-7z",
  pause: "M8 5v14M16 5v14",
  ceiling: "M3 7h18M5 7v12h14V7M9 3.500l3-1.500 3 1.500",
  camera: "M4 8h3l2-3h6l2 3h3v11H4zM12 10.500a3 3 0 1 0 .01 0",
  theme: "M12 4a8 8 0 1 0 8 8 6 6 0 0 1-8-8z",
  close: "M6 6l12 12M18 6 6 18",
  isolate: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5M12 9.500a2.500 2.500 0 1 0 .01 0",
  fly: "M4 12 20 4l-6 16-3-6z",
  list: "M4 6h16M4 12h16M4 18h16",
  help: "M9 9a3 3 0 1 1 4 3c-1 .5-1 1-1 2M12 17.500v.01",
  undo: "M8 5 4 9l4 4M4 9h10a5 5 0 0 1 0 10h-3",
  redo: "M16 5l4 4-4 4M20 9H10a5 5 0 0 0 0 10h3",
  edit: "M4 20l1-4L16 5l3 3L8 19z",
  filter: "M4 6h16M7 12h10M10 18h4",
  image: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15.500 9a1 1 0 1 0 .01 0",
  compare: "M12 3v18M4 6h5v12H4M20 6h-5v12h5",
};

export function icon(name: string): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

export function iconButton(name: string, label: string, onclick: () => void, text = ""): HTMLButtonElement {
  const properties = { type: "button", className: "icon-button", title: label, onclick, "aria-label": label };
  return make("button", properties, icon(name), text && make("span", {}, text));
}
