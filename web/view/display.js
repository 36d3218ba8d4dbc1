// From the half floats of a frame to the colors of a display. There are 65536 of them: what each looks like is in a table, and
// a change of the exposure costs a table and a pass over the pixels.
import { encode, heatColor } from "./color.js";
import { floatOfHalf } from "./pixels.js";

const kHalfs = Float32Array.from({ length: 65536 }, (_, bits) => floatOfHalf(bits));

// As filmicCurve in src/image/tonemap.cpp.
function filmic(linear) {
  const x = Math.min(Math.max(linear, 0), 1e4);
  return Math.min(1, (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14));
}

function table(shown) {
  const bytes = new Uint8Array(65536);
  for (let bits = 0; bits < 65536; ++bits) bytes[bits] = shown(kHalfs[bits]);
  return bytes;
}

let made = { key: "", bytes: null };
function cached(key, shown) {
  if (made.key !== key) made = { key, bytes: table(shown) };
  return made.bytes;
}

// Relative errors on the scale of `metrolux compare --heatmap`.
function heat(halfs, data) {
  const colors = cached("heat", (error) => (Number.isFinite(error) ? heatPosition(error) * 255 : 255));
  const scale = Array.from({ length: 256 }, (_, i) => heatColor(i / 255));
  for (let i = 0, o = 0; i < halfs.length; ++i, o += 4) {
    const color = scale[colors[halfs[i]]];
    data[o] = color[0];
    data[o + 1] = color[1];
    data[o + 2] = color[2];
    data[o + 3] = 255;
  }
}
const heatPosition = (error) => Math.min(Math.max(Math.log10(Math.max(error, 1e-3)) / 3 + 1, 0), 1);

function largest(halfs) {
  let most = 0;
  for (let i = 0; i < halfs.length; ++i) {
    const value = kHalfs[halfs[i]];
    if (value > most && value < Infinity) most = value;
  }
  return most || 1;
}

function shownAs(frame, exposure, curve) {
  const factor = 2 ** exposure;
  switch (frame.layer) {
    case "normal":
      return cached("normal", (n) => Math.round(255 * Math.min(Math.max(0.5 + 0.5 * n, 0), 1)));
    case "depth": {
      const most = largest(frame.halfs);
      return cached(`depth ${most} ${factor}`, (z) => Math.round(255 * Math.min((factor * z) / most, 1)));
    }
    case "color":
      if (curve === "filmic") return cached(`filmic ${factor}`, (value) => encode(filmic(factor * value)));
  }
  return cached(`srgb ${factor}`, (value) => encode(factor * value));
}

export function imageOf(frame, exposure, curve) {
  const { halfs, width, height, channels } = frame;
  const image = new ImageData(width, height);
  const data = image.data;
  if (frame.layer === "error") {
    heat(halfs, data);
    return image;
  }
  const bytes = shownAs(frame, exposure, curve);
  const [green, blue] = channels === 3 ? [1, 2] : [0, 0];
  for (let i = 0, o = 0; o < data.length; i += channels, o += 4) {
    data[o] = bytes[halfs[i]];
    data[o + 1] = bytes[halfs[i + green]];
    data[o + 2] = bytes[halfs[i + blue]];
    data[o + 3] = 255;
  }
  return image;
}
