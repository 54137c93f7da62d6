// Short messages, which screen readers speak.
import { byId } from "./elements";

let timer = 0;

export function say(text: string, seconds = 5): void {
  const toast = byId("toast");
  toast.textContent = text;
  toast.classList.toggle("shown", Boolean(text));
  clearTimeout(timer);
  if (text) timer = window.setTimeout(() => toast.classList.remove("shown"), 1000 * seconds);
}
