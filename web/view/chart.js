// The estimated error of each side over its seconds, both logarithmic.

const kColors = ["#6fb1ff", "#ffb454"];
const kInk = "#a2a6ac";
const kGrid = "#33363a";

// Round numbers: few digits where the range is wide, more where it is narrow.
function roundNumbers(from, to) {
  const digits = to / from > 8 ? [1, 2, 5] : to / from > 2.5 ? [1, 1.5, 2, 3, 4, 5, 6, 8] : [1, 1.2, 1.4, 1.6, 1.8, 2, 2.2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8, 9];
  const ticks = [];
  for (let e = Math.floor(Math.log10(from)); e <= Math.ceil(Math.log10(to)); ++e)
    for (const digit of digits) {
      const value = digit * 10 ** e;
      if (value >= from * 0.999 && value <= to * 1.001) ticks.push(value);
    }
  return ticks;
}
const short = (value) => String(Number(value.toPrecision(2)));
const percent = (value) => `${short(100 * value)} %`;

export function drawChart(canvas, curves) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.font = "11px system-ui, sans-serif";
  const points = curves.flat().filter(([seconds, error]) => seconds > 0 && error > 0);
  if (points.length < 2) {
    context.fillStyle = kInk;
    context.textAlign = "center";
    context.fillText("known after eight passes", width / 2, height / 2);
    return;
  }
  const range = (index) => {
    const values = points.map((point) => point[index]);
    const low = Math.min(...values);
    const high = Math.max(...values);
    return high > 1.5 * low ? [low, high] : [low / 1.3, high * 1.3];
  };
  const [x0, x1] = range(0);
  const [y0, y1] = range(1);
  const left = 40;
  const bottom = height - 18;
  const x = (value) => left + (Math.log(value / x0) / Math.log(x1 / x0)) * (width - left - 8);
  const y = (value) => bottom - (Math.log(value / y0) / Math.log(y1 / y0)) * (bottom - 8);
  const line = (ax, ay, bx, by) => {
    context.beginPath();
    context.moveTo(ax, ay);
    context.lineTo(bx, by);
    context.stroke();
  };
  context.strokeStyle = kGrid;
  context.fillStyle = kInk;
  context.textBaseline = "middle";
  context.textAlign = "right";
  let last = Infinity;
  for (const tick of roundNumbers(y0, y1)) {
    line(left, y(tick), width - 8, y(tick));
    if (last - y(tick) > 14) context.fillText(percent(tick), left - 5, (last = y(tick)));
  }
  context.textAlign = "center";
  last = -Infinity;
  for (const tick of roundNumbers(x0, x1)) {
    line(x(tick), 8, x(tick), bottom);
    const text = short(tick);
    if (x(tick) - last > 34) context.fillText(text, (last = x(tick)), height - 7);
  }
  curves.forEach((curve, side) => {
    context.strokeStyle = kColors[side];
    context.lineWidth = 1.75;
    context.lineJoin = "round";
    context.beginPath();
    for (const [seconds, error] of curve)
      if (seconds > 0 && error > 0) context.lineTo(x(seconds), y(error));
    context.stroke();
  });
}
