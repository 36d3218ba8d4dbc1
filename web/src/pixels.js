// Images of the page: what encodePixels in src/study/page.cpp wrote.

function bytesOfBase64(text) {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// IEEE 754 binary16.
export function floatOfHalf(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

function floatsOfPlanes(planes, half) {
  const count = planes.length / (half ? 2 : 4);
  const values = new Float32Array(count);
  if (half) {
    for (let i = 0; i < count; ++i) values[i] = floatOfHalf(planes[i] | (planes[count + i] << 8));
    return values;
  }
  const bits = new Uint32Array(values.buffer);
  for (let i = 0; i < count; ++i)
    bits[i] =
      planes[i] | (planes[count + i] << 8) | (planes[2 * count + i] << 16) | (planes[3 * count + i] << 24);
  return values;
}

export async function decodeImage({ name, width, height, pixels }, precision) {
  const planes = await inflate(bytesOfBase64(pixels));
  const values = floatsOfPlanes(planes, precision === "half");
  if (values.length !== width * height * 3) throw new Error(`image of ${name}: the pixels are incomplete`);
  return { name, width, height, values };
}

// The fewest digits that tell a number from its neighbors of single precision.
export function shortestText(value) {
  if (!Number.isFinite(value)) return String(value);
  for (let digits = 1; digits < 9; ++digits) {
    const text = value.toPrecision(digits);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(Number(value.toPrecision(9)));
}

// Half precision has 11 bits: four digits tell neighbors apart, five name each.
export function halfText(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(5))) : String(value);
}
