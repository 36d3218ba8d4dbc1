// Display colors: the sRGB encoding of writePng and the error scale of errorHeatMap (src/image).

const kTableSize = 1 << 14;
const kSrgb = new Uint8Array(kTableSize + 1);
for (let i = 0; i <= kTableSize; ++i) {
  const v = i / kTableSize;
  kSrgb[i] = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

export function encode(value) {
  if (!(value > 0)) return 0;
  return value >= 1 ? 255 : kSrgb[(value * kTableSize + 0.5) | 0];
}

export function displayPixels(image, exposure) {
  const factor = 2 ** exposure;
  const { values, width, height } = image;
  const result = new ImageData(width, height);
  for (let i = 0, o = 0; o < result.data.length; o += 4) {
    for (let c = 0; c < 3; ++c) result.data[o + c] = encode(factor * values[i++]);
    result.data[o + 3] = 255;
  }
  return result;
}

const kStops = [
  [0.0, 0.0, 0.0],
  [0.08, 0.12, 0.55],
  [0.55, 0.1, 0.6],
  [0.93, 0.42, 0.15],
  [0.99, 0.86, 0.25],
  [1.0, 1.0, 1.0],
];

// Position 0..1 on the scale to a display color.
export function heatColor(t) {
  const position = Math.min(Math.max(t, 0), 1) * 5;
  const stop = Math.min(Math.floor(position), 4);
  return [0, 1, 2].map((c) => {
    const a = kStops[stop][c];
    return Math.round(255 * (a + (position - stop) * (kStops[stop + 1][c] - a)));
  });
}

const kHeat = Array.from({ length: 1024 }, (_, i) => heatColor(i / 1023));

// Relative error of a pixel: the root of the mean over channels of (a-b)^2 / (b^2 + epsilon).
export function relativeError(a, b, index, epsilon) {
  let sum = 0;
  for (let c = 0; c < 3; ++c) {
    const difference = a[index + c] - b[index + c];
    sum += (difference * difference) / (b[index + c] * b[index + c] + epsilon);
  }
  return Math.sqrt(sum / 3);
}

export function errorPixels(image, reference, epsilon) {
  const result = new ImageData(image.width, image.height);
  for (let i = 0, o = 0; o < result.data.length; i += 3, o += 4) {
    const error = relativeError(image.values, reference.values, i, epsilon);
    const position = Math.log10(Math.max(error, 1e-3)) / 3 + 1;
    const color = Number.isFinite(error) ? kHeat[Math.round(Math.min(position, 1) * 1023)] : [0, 255, 0];
    result.data.set(color, o);
    result.data[o + 3] = 255;
  }
  return result;
}
