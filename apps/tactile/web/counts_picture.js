// Pictures of counts: the events of the last history, and the heatmap that a network gets. Decoding has no document in it.

import { Latest } from "./latest.js";
import { darkScheme, el } from "./dom.js";
import { countText } from "./format.js";

const HEADER_BYTES = 16;

/// {width, height, on, off, first, second} of an answer: numbers of events, then one or two planes of bytes.
export function countsOf(buffer) {
  const head = new DataView(buffer, 0, HEADER_BYTES);
  const [width, height, on, off] = [0, 4, 8, 12].map((at) => head.getUint32(at, true));
  const size = width * height;
  const planes = (buffer.byteLength - HEADER_BYTES) / size;
  if (planes !== 1 && planes !== 2) throw new Error(`${buffer.byteLength} bytes for ${width} x ${height} pixels`);
  const plane = (n) => (n < planes ? new Uint8Array(buffer, HEADER_BYTES + n * size, size) : null);
  return { width, height, on, off, first: plane(0), second: plane(1) };
}

// The scale of the pictures of `tactile view`: black, violet, red, yellow, nearly white (inferno), at nine places.
const STOPS = [
  [0, 0, 4],
  [31, 12, 72],
  [85, 15, 109],
  [136, 34, 106],
  [186, 54, 85],
  [227, 89, 51],
  [249, 140, 10],
  [249, 201, 50],
  [252, 255, 164],
];

/// 256 colours of the heatmap, as red, green, blue.
export function heatScale() {
  return Array.from({ length: 256 }, (_, value) => {
    const place = (value / 255) * (STOPS.length - 1);
    const from = Math.min(Math.floor(place), STOPS.length - 2);
    return STOPS[from].map((c, i) => Math.round(c + (STOPS[from + 1][i] - c) * (place - from)));
  });
}

const SCALE = heatScale();

/// Fills `pixels` (RGBA). ON is blue and OFF is red; more events of a pixel are stronger, and both at once are violet.
export function paintEvents({ first, second }, pixels, dark) {
  const paper = dark ? 22 : 255;
  const strength = Uint8Array.from({ length: 256 }, (_, n) => (n === 0 ? 0 : Math.min(255, 110 + 60 * Math.log2(1 + n))));
  for (let i = 0; i < first.length; ++i) {
    const on = strength[first[i]];
    const off = strength[second[i]];
    const at = 4 * i;
    if (dark) {
      pixels[at] = Math.max(paper, off, on >> 2);
      pixels[at + 1] = Math.max(paper, (on * 5) >> 3, off >> 2);
      pixels[at + 2] = Math.max(paper, on);
    } else {
      pixels[at] = paper - on;
      pixels[at + 1] = paper - Math.max(on >> 1, off);
      pixels[at + 2] = paper - off;
    }
    pixels[at + 3] = 255;
  }
}

export function paintHeat({ first }, pixels) {
  for (let i = 0; i < first.length; ++i) {
    const [r, g, b] = SCALE[first[i]];
    pixels[4 * i] = r;
    pixels[4 * i + 1] = g;
    pixels[4 * i + 2] = b;
    pixels[4 * i + 3] = 255;
  }
}

/// A canvas that follows the cursor. `load(at_us, {signal})` gives the bytes.
export class CountsPicture {
  constructor({ title, kind, load, failed }) {
    this.kind = kind;
    this.caption = el("figcaption", {}, title);
    this.canvas = el("canvas", { role: "img", "aria-label": title, width: 4, height: 3 });
    this.number = el("span", { class: "number" });
    this.caption.append(this.number);
    this.element = el("figure", { class: `picture ${kind}` }, el("div", { class: "frame" }, this.canvas), this.caption);
    this.latest = new Latest(async (at_us, signal) => this.#draw(countsOf(await load(at_us, { signal }))), failed);
    this.repaint = () => this.last && this.#draw(this.last);
    darkScheme.addEventListener("change", this.repaint);
  }

  show(at_us) {
    this.latest.ask(at_us);
  }

  again(at_us) {
    this.show(at_us);
  }

  #draw(counts) {
    this.last = counts;
    const { width, height, on, off } = counts;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const context = this.canvas.getContext("2d");
    const image = context.createImageData(width, height);
    if (this.kind === "events") paintEvents(counts, image.data, darkScheme.matches);
    else paintHeat(counts, image.data);
    context.putImageData(image, 0, 0);
    this.number.textContent = this.kind === "events" ? `${countText(on)} ON, ${countText(off)} OFF` : `${countText(on)} events`;
  }

  stop() {
    this.latest.stop();
    darkScheme.removeEventListener("change", this.repaint);
  }
}
