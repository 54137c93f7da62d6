// Starts the page with the source that its HTML names.
import { App } from "./app";
import { byId } from "./panels/elements";
import { inlineSource } from "./sources/inline";
import { servedSource } from "./sources/served";

async function start(): Promise<void> {
  const { kind } = JSON.parse(byId("razer-source").textContent!);
  const app = new App(kind === "served" ? servedSource() : inlineSource());
  await app.start();
}

// The shell is painted before the map is opened.
const painted = new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));

painted.then(start).catch((error: Error) => {
  const place = document.getElementById("loading") ?? document.body;
  place.classList.add("failed");
  place.textContent = `The map could not be opened: ${error.message}`;
  throw error;
});
