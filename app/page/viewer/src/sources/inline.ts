// A map inside the page itself.
import type { MapSource } from "./source";

export function inlineSource(): MapSource {
  return {
    server: null,
    load(decoder) {
      const holder = document.getElementById("razer-payload")!;
      const text = holder.textContent!;
      holder.remove(); // megabytes that nobody needs twice
      return decoder.map(text);
    },
  };
}
