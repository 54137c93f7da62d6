// Colours that people with any colour vision tell apart: Tol's "muted" hues, softened, in two lightnesses; surfaces
// that are not counted stay pale, so that things stand out of them.
export type Rgb = [number, number, number];

const HUES: Rgb[] = [
  [86, 140, 193], [222, 142, 79], [92, 165, 138], [190, 104, 137], [214, 186, 98],
  [125, 113, 178], [143, 190, 218], [166, 90, 74], [134, 164, 84], [200, 158, 190],
];
const STUFF: Rgb[] = [
  [201, 197, 189], [184, 190, 198], [211, 203, 186], [190, 197, 188], [205, 195, 200],
];
export const NOBODY: Rgb = [176, 178, 182];
// Viridis without its darkest end.
const CONFIDENCE: Rgb[] = [
  [72, 71, 121], [57, 104, 140], [38, 138, 141], [53, 171, 118], [133, 204, 70], [240, 222, 60],
];

function shade(color: Rgb, factor: number): Rgb {
  return color.map((part) => Math.round(factor > 1 ? 255 - (255 - part) / factor : part * factor)) as Rgb;
}

/** Neighbouring numbers get unlike hues. */
function nth(colors: Rgb[], number: number): Rgb {
  const round = Math.floor(number / colors.length) % 3;
  return shade(colors[number % colors.length], [1, 0.8, 1.35][round]);
}

export function instanceColor(place: number, isStuff: boolean): Rgb {
  return nth(isStuff ? STUFF : HUES, place);
}

/** A class's colour by its place among the classes of the map; stuff has the same hues, paler. */
export function classColor(place: number, isStuff: boolean): Rgb {
  const color = nth(HUES, place);
  return isStuff ? (color.map((part) => Math.round(0.42 * part + 0.58 * 205)) as Rgb) : color;
}

export function confidenceColor(share: number): Rgb {
  const place = Math.min(Math.max(share, 0), 1) * (CONFIDENCE.length - 1);
  const low = Math.min(Math.floor(place), CONFIDENCE.length - 2);
  const part = place - low;
  return CONFIDENCE[low].map((value, i) => Math.round(value + part * (CONFIDENCE[low + 1][i] - value))) as Rgb;
}

export const css = (color: Rgb): string => `rgb(${color.join(" ")})`;
